// The pages of a TIFF file through libtiff, which is seen by tiff_pages.cpp alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

class TiffPages {
 public:
  // Throws VolumeFileError unless it is a TIFF file whose chain of pages ends inside it. Reduced
  // copies of other pages (thumbnails, pyramids) are no pages.
  explicit TiffPages(std::filesystem::path file);
  ~TiffPages();
  TiffPages(TiffPages&&) noexcept;

  [[nodiscard]] std::size_t count() const { return pages_.size(); }

  // The size, the type and the components of the samples of a page. Integers of fewer than 8 bits
  // become u8, of 9 to 15 bits u16; floats of 16 bits f32. Throws VolumeFileError when it has
  // samples of another kind.
  [[nodiscard]] ImageHeader header(std::size_t page) const;
  // ImageDescription, and the resolution in pixels a unit, of the first page.
  [[nodiscard]] const std::string& description() const { return description_; }
  struct Resolution {
    // 0: unknown.
    double x = 0;
    double y = 0;
    double unit_mm = 0;  // 0: no unit.
  };
  [[nodiscard]] const Resolution& resolution() const { return resolution_; }
  // Where the samples of the first page begin, if they are not packed and lie one after the other.
  [[nodiscard]] std::optional<std::uint64_t> plain_offset() const { return plain_offset_; }
  [[nodiscard]] bool is_big_endian() const;

  // The samples of a page as they are stored, rows from the top and components one after the other.
  // Requires room for header(page).slice_bytes(). Throws VolumeFileError.
  void read(std::size_t page, std::byte* into) const;

 private:
  struct Reader;
  void select(std::size_t page) const;

  std::filesystem::path file_;
  std::unique_ptr<Reader> reader_;
  std::vector<std::uint64_t> pages_;  // Where their directories are.
  std::string description_;
  Resolution resolution_;
  std::optional<std::uint64_t> plain_offset_;
};

}  // namespace multitetra

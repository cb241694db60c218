// Reads the pages of a TIFF file by libtiff, which no other file includes but tiff_tags.
#pragma once

#include <array>
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
  // Throws VolumeFileError unless the file is a TIFF whose chain of pages ends within it. Skips
  // reduced copies of other pages (thumbnails, pyramids).
  explicit TiffPages(std::filesystem::path file);
  ~TiffPages();
  TiffPages(TiffPages&&) noexcept;
  TiffPages& operator=(TiffPages&&) noexcept;

  [[nodiscard]] std::size_t count() const { return pages_.size(); }

  // Returns the size, type and components of a page's samples. Integers of fewer than 8 bits become
  // u8, those of 9 to 15 bits u16, and 16-bit floats f32. Throws VolumeFileError for other samples.
  [[nodiscard]] ImageHeader header(std::size_t page) const;
  // ImageDescription and resolution (pixels per unit) of the first page.
  [[nodiscard]] const std::string& description() const { return description_; }
  // The descriptions that begin images of tifffile, each of one or several pages.
  struct Shape {
    std::size_t page = 0;
    std::string text;
  };
  [[nodiscard]] const std::vector<Shape>& shapes() const { return shapes_; }
  struct Resolution {
    // 0 if unknown.
    double x = 0;
    double y = 0;
    double unit_mm = 0;  // 0 if there is no unit.
  };
  [[nodiscard]] const Resolution& resolution() const { return resolution_; }
  // Offset of the samples of the first page, if they are uncompressed and contiguous.
  [[nodiscard]] std::optional<std::uint64_t> plain_offset() const { return plain_offset_; }
  // Where samples are, as tags of MetaMorph (stacks) and GeoTIFF state it.
  struct Placement {
    std::array<std::optional<double>, 3> spacing = {};
    std::array<std::string, 3> units = {};  // Empty if unknown.
    bool is_on_map = false;                 // By GeoTIFF, whose tags are not read.
    std::string unread;  // The program whose tags state it, if they are not read.
    // The number of missing samples, by GDAL.
    std::optional<double> missing = std::nullopt;
  };
  [[nodiscard]] const Placement& placement() const { return placement_; }
  // value = slope * stored + intercept, by GDAL.
  struct Scaling {
    std::optional<double> slope = std::nullopt;
    double intercept = 0;
    bool differs = false;  // Each component has its own.
  };
  [[nodiscard]] const Scaling& scaling() const { return scaling_; }
  // Images that the first directory has by its tags: of MetaMorph stacks, or its ImageDepth.
  [[nodiscard]] std::int64_t images_in_first() const { return images_in_first_; }
  // Whether the file has directories that are not pages: reduced copies, or those of other tags.
  [[nodiscard]] bool has_other_directories() const { return has_other_directories_; }
  [[nodiscard]] bool is_big_endian() const;

  // Reads the samples of a page as stored, rows from the top, components interleaved. Requires
  // header(page).slice_bytes() bytes at `into`. Throws VolumeFileError.
  void read(std::size_t page, std::byte* into) const;

 private:
  struct Reader;
  void select(std::size_t page) const;

  std::filesystem::path file_;
  std::unique_ptr<Reader> reader_;
  std::vector<std::uint64_t> pages_;  // Offsets of their directories.
  std::string description_;
  std::vector<Shape> shapes_;
  Resolution resolution_;
  Placement placement_;
  Scaling scaling_;
  std::optional<std::uint64_t> plain_offset_;
  std::int64_t images_in_first_ = 1;
  bool has_other_directories_ = false;
};

}  // namespace multitetra

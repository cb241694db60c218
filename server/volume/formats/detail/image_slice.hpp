// The slice of an image file, decoded on first access. `Reading` decodes a format: read_rows(into,
// row_bytes) fills all rows, or returns false with problem() if the image is damaged.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {

// Notes a resolution that the file states, unless it is that of screens. It is that of paper more
// often than that of samples, so it is not used.
inline void note_resolution(ImageHeader& header, double x_mm, double y_mm) {
  const double per_inch = std::round(25.4 / x_mm);
  if (x_mm == y_mm && (per_inch == 72 || per_inch == 96)) return;
  header.contradictions.push_back({Fact::kSpacing, "its resolution of " + rounded_text(x_mm) +
                                                       " by " + rounded_text(y_mm) +
                                                       " mm is not used"});
}

template <typename Reading>
class ImageSlice : public StoredSlices {
 public:
  // `library` is named in the error for a damaged image.
  ImageSlice(std::filesystem::path file, std::string_view library, std::unique_ptr<Reading> reading,
             const ImageHeader& header)
      : file_(std::move(file)), library_(library), reading_(std::move(reading)), header_(header) {}

  void read(std::size_t /*first*/, std::size_t /*count*/, std::byte* into) override {
    if (samples_.empty()) decode();
    std::memcpy(into, samples_.data(), samples_.size());
  }

 private:
  void decode() {
    std::vector<std::byte> samples(header_.slice_bytes());
    const std::size_t row_bytes = samples.size() / static_cast<std::size_t>(header_.dims[1]);
    if (!reading_->read_rows(samples.data(), row_bytes)) {
      fail_damaged(file_,
                   "it is damaged (" + library_ + ": " + std::string(reading_->problem()) + ")");
    }
    reading_.reset();
    samples_ = std::move(samples);
  }

  std::filesystem::path file_;
  std::string library_;
  std::unique_ptr<Reading> reading_;  // Null once the samples are decoded.
  ImageHeader header_;
  std::vector<std::byte> samples_;
};

// Opens an image as a volume. Errors about its header name `format` and `library`.
template <typename Reading>
StoredVolume open_image(const std::filesystem::path& path, const std::string& format,
                        const std::string& library) {
  const InputFile file(path);
  auto reading = std::make_unique<Reading>(file.beginning(file.size()));
  if (!reading->read_header()) {
    fail_damaged(path, "it is not a complete " + format + " image (" + library + ": " +
                           std::string(reading->problem()) + ")");
  }
  const ImageHeader header = reading->header();
  check_header(path, header);
  return {
      .header = header,
      .slices = std::make_unique<ImageSlice<Reading>>(path, library, std::move(reading), header)};
}

}  // namespace multitetra

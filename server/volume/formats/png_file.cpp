#include "server/volume/formats/png_file.hpp"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// A PNG in memory while libpng reads it. libpng leaves its functions by longjmp, so those that call
// it have no objects of their own.
class PngReading {
 public:
  explicit PngReading(std::string bytes)
      : bytes_(std::move(bytes)),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, this, &on_error, &on_warning)),
        info_(png_create_info_struct(png_)) {
    png_set_read_fn(png_, this, &on_read);
  }
  ~PngReading() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReading(const PngReading&) = delete;
  PngReading& operator=(const PngReading&) = delete;

  [[nodiscard]] bool read_header() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_info(png_, info_);
    png_set_packing(png_);  // Numbers of fewer than 8 bits become bytes.
    if (png_get_bit_depth(png_, info_) == 16) png_set_swap(png_);
    (void)png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  [[nodiscard]] bool read_rows(png_bytep* rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  [[nodiscard]] ImageHeader header() const {
    ImageHeader header{
        .type = png_get_bit_depth(png_, info_) == 16 ? StoredType::kU16 : StoredType::kU8,
        .components = png_get_channels(png_, info_)};
    header.dims = {png_get_image_width(png_, info_), png_get_image_height(png_, info_), 1};
    return header;
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  static void on_error(png_structp png, png_const_charp text) {
    static_cast<PngReading*>(png_get_error_ptr(png))->problem_ = text;
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
  static void on_read(png_structp png, png_bytep into, size_t count) {
    auto* const self = static_cast<PngReading*>(png_get_io_ptr(png));
    if (count > self->bytes_.size() - self->at_) png_error(png, "it ends too early");
    std::memcpy(into, self->bytes_.data() + self->at_, count);
    self->at_ += count;
  }

  std::string bytes_;
  std::size_t at_ = 0;
  std::string problem_;
  png_structp png_;
  png_infop info_;
};

class PngSlice : public StoredSlices {
 public:
  PngSlice(fs::path file, std::unique_ptr<PngReading> reading, const ImageHeader& header)
      : file_(std::move(file)), reading_(std::move(reading)), header_(header) {}

  void read(std::size_t /*first*/, std::size_t /*count*/, std::byte* into) override {
    if (samples_.empty()) decode();
    std::memcpy(into, samples_.data(), samples_.size());
  }

 private:
  void decode() {
    std::vector<std::byte> samples(header_.slice_bytes());
    const std::size_t row_bytes = samples.size() / static_cast<std::size_t>(header_.dims[1]);
    std::vector<png_bytep> rows;
    for (std::size_t at = 0; at < samples.size(); at += row_bytes) {
      rows.push_back(reinterpret_cast<png_bytep>(samples.data() + at));
    }
    if (!reading_->read_rows(rows.data())) {
      fail_reading(file_, "it is damaged (libpng: " + reading_->problem() + ")",
                   "Get a whole copy of it");
    }
    reading_.reset();
    samples_ = std::move(samples);
  }

  fs::path file_;
  std::unique_ptr<PngReading> reading_;  // Until the samples are decoded.
  ImageHeader header_;
  std::vector<std::byte> samples_;
};

}  // namespace

StoredVolume open_png(const fs::path& path) {
  const InputFile file(path);
  auto reading = std::make_unique<PngReading>(file.beginning(file.size()));
  if (!reading->read_header()) {
    fail_reading(path, "it is no whole PNG image (libpng: " + reading->problem() + ")",
                 "Get a whole copy of it");
  }
  const ImageHeader header = reading->header();
  check_header(path, header);
  return {.header = header, .slices = std::make_unique<PngSlice>(path, std::move(reading), header)};
}

}  // namespace multitetra

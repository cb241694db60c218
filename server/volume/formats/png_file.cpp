#include "server/volume/formats/png_file.hpp"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/image_slice.hpp"

namespace multitetra {
namespace {

// A PNG in memory. libpng reports errors by longjmp, so functions that call it have no objects with
// destructors.
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
    png_set_packing(png_);  // Expands numbers of fewer than 8 bits to bytes.
    if (png_get_bit_depth(png_, info_) == 16) png_set_swap(png_);
    (void)png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  [[nodiscard]] bool read_rows(std::byte* into, std::size_t row_bytes) {
    rows_.clear();
    for (std::uint32_t row = 0; row < png_get_image_height(png_, info_); ++row) {
      rows_.push_back(reinterpret_cast<png_bytep>(into + row * row_bytes));
    }
    return read_rows();
  }

  [[nodiscard]] ImageHeader header() const {
    ImageHeader header{
        .type = png_get_bit_depth(png_, info_) == 16 ? StoredType::kU16 : StoredType::kU8,
        .values = {Basis::kByFormat, Basis::kByFormat, Basis::kByFormat},
        .components = png_get_channels(png_, info_)};
    header.dims = {png_get_image_width(png_, info_), png_get_image_height(png_, info_), 1};
    if (png_get_color_type(png_, info_) == PNG_COLOR_TYPE_PALETTE) note_palette(header);
    std::uint32_t x = 0;
    std::uint32_t y = 0;
    int unit = PNG_RESOLUTION_UNKNOWN;
    png_get_pHYs(png_, info_, &x, &y, &unit);
    if (unit == PNG_RESOLUTION_METER && x > 0 && y > 0) {
      note_resolution(header, 1000.0 / x, 1000.0 / y);
    }
    return header;
  }
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  [[nodiscard]] bool read_rows() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows_.data());
    png_read_end(png_, nullptr);
    return true;
  }
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
  std::vector<png_bytep> rows_;
  png_structp png_;
  png_infop info_;
};

}  // namespace

StoredVolume open_png(const std::filesystem::path& path) {
  return open_image<PngReading>(path, "PNG", "libpng");
}

}  // namespace multitetra

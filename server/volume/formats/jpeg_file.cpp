#include "server/volume/formats/jpeg_file.hpp"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>  // Before jpeglib.h, which lacks it.
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <jpeglib.h>

#include "server/volume/formats/detail/image_slice.hpp"

namespace multitetra {
namespace {

// A JPEG in memory. libjpeg reports errors by longjmp, so functions that call it have no objects
// with destructors.
class JpegReading {
 public:
  explicit JpegReading(std::string bytes) : bytes_(std::move(bytes)) {
    jpeg_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = &on_error;
    errors_.base.emit_message = &on_message;
    jpeg_create_decompress(&jpeg_);
    progress_.progress_monitor = &on_progress;
    jpeg_.progress = &progress_;
  }
  ~JpegReading() { jpeg_destroy_decompress(&jpeg_); }
  JpegReading(const JpegReading&) = delete;
  JpegReading& operator=(const JpegReading&) = delete;

  [[nodiscard]] bool read_header() {
    if (setjmp(errors_.leave) != 0) return false;
    jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes_.data()), bytes_.size());
    (void)jpeg_read_header(&jpeg_, TRUE);
    jpeg_.out_color_space = jpeg_.num_components == 1   ? JCS_GRAYSCALE
                            : jpeg_.num_components == 4 ? JCS_CMYK
                                                        : JCS_RGB;
    jpeg_calc_output_dimensions(&jpeg_);
    return true;
  }
  [[nodiscard]] bool read_rows(std::byte* into, std::size_t row_bytes) {
    if (setjmp(errors_.leave) != 0) return false;
    jpeg_.dct_method = JDCT_ISLOW;  // Gives the same samples on every machine.
    (void)jpeg_start_decompress(&jpeg_);
    while (jpeg_.output_scanline < jpeg_.output_height) {
      auto* row = reinterpret_cast<JSAMPROW>(into + jpeg_.output_scanline * row_bytes);
      (void)jpeg_read_scanlines(&jpeg_, &row, 1);
    }
    (void)jpeg_finish_decompress(&jpeg_);
    return true;
  }

  [[nodiscard]] ImageHeader header() const {
    ImageHeader header{.type = StoredType::kU8,
                       .values = {Basis::kByFormat, Basis::kByFormat, Basis::kByFormat},
                       .components = jpeg_.out_color_components};
    header.dims = {jpeg_.image_width, jpeg_.image_height, 1};
    const double unit_mm = jpeg_.density_unit == 1 ? 25.4 : jpeg_.density_unit == 2 ? 10.0 : 0.0;
    if (unit_mm > 0 && jpeg_.X_density > 0 && jpeg_.Y_density > 0) {
      note_resolution(header, unit_mm / jpeg_.X_density, unit_mm / jpeg_.Y_density);
    }
    return header;
  }
  [[nodiscard]] std::string problem() const { return errors_.problem.data(); }

 private:
  struct Errors {
    jpeg_error_mgr base;  // First member: libjpeg passes a pointer to it.
    std::jmp_buf leave;
    std::array<char, JMSG_LENGTH_MAX> problem{};
  };

  static void on_error(j_common_ptr jpeg) {
    auto& errors = *reinterpret_cast<Errors*>(jpeg->err);
    (*jpeg->err->format_message)(jpeg, errors.problem.data());
    std::longjmp(errors.leave, 1);
  }
  // Warnings indicate damage, after which libjpeg invents samples.
  static void on_message(j_common_ptr jpeg, int level) {
    if (level < 0) on_error(jpeg);
  }
  // Progressive images may have any number of scans, each as costly as the whole image.
  static void on_progress(j_common_ptr jpeg) {
    constexpr int kMaxScans = 500;
    auto& errors = *reinterpret_cast<Errors*>(jpeg->err);
    if (!jpeg->is_decompressor ||
        reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMaxScans) {
      return;
    }
    (void)std::snprintf(errors.problem.data(), errors.problem.size(), "it has too many scans");
    std::longjmp(errors.leave, 1);
  }

  std::string bytes_;
  Errors errors_{};
  jpeg_progress_mgr progress_{};
  jpeg_decompress_struct jpeg_{};
};

}  // namespace

StoredVolume open_jpeg(const std::filesystem::path& path) {
  return open_image<JpegReading>(path, "JPEG", "libjpeg");
}

}  // namespace multitetra

#include "server/volume/formats/detail/tiff_pages.hpp"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/half_floats.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/tiff_tags.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {
namespace {

// The last message of libtiff, whose error handler is global.
thread_local std::string tiff_problem;

void keep_problem(const char* /*module*/, const char* format, va_list arguments) {
  std::array<char, 400> text{};
  (void)std::vsnprintf(text.data(), text.size(), format, arguments);
  tiff_problem = text.data();
}

// The storage format of a page's samples.
struct PageFormat {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bits = 1;
  std::uint16_t components = 1;
  std::uint16_t kind = SAMPLEFORMAT_UINT;
  bool is_planar = false;
  bool is_tiled = false;
  bool is_upside_down = false;

  [[nodiscard]] bool is_half() const { return kind == SAMPLEFORMAT_IEEEFP && bits == 16; }
  // Bytes of a stored row, of one component if planar, else of all.
  [[nodiscard]] std::size_t row_bytes(std::size_t columns) const {
    return (columns * bits * (is_planar ? 1U : components) + 7) / 8;
  }
};

PageFormat format_of(TIFF* tiff) {
  PageFormat format;
  format.width = tiff_field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0);
  format.height = tiff_field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0);
  format.bits = tiff_field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  format.components = tiff_field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  format.kind = tiff_field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  format.is_planar = format.components > 1 &&
                     tiff_field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) ==
                         PLANARCONFIG_SEPARATE;
  format.is_tiled = TIFFIsTiled(tiff) != 0;
  format.is_upside_down =
      tiff_field<std::uint16_t>(tiff, TIFFTAG_ORIENTATION, 1) == ORIENTATION_BOTLEFT;
  return format;
}

std::optional<StoredType> stored_type_of(const PageFormat& format) {
  const bool is_signed = format.kind == SAMPLEFORMAT_INT;
  int bits = format.bits;
  if (format.kind == SAMPLEFORMAT_IEEEFP) {
    return stored_type_from("f" + std::to_string(bits == 16 ? 32 : bits));
  }
  if (!is_signed && format.kind != SAMPLEFORMAT_UINT && format.kind != SAMPLEFORMAT_VOID) {
    return std::nullopt;
  }
  if (!is_signed && bits >= 1 && bits < 16) bits = bits <= 8 ? 8 : 16;
  return stored_type_from((is_signed ? "i" : "u") + std::to_string(bits));
}

// Converts `count` numbers of a row to the reader's format, `step` bytes apart.
void unpack_row(const PageFormat& format, std::span<const std::byte> row, std::size_t count,
                std::byte* into, std::size_t width, std::size_t step) {
  for (std::size_t i = 0; i < count; ++i, into += step) {
    if (format.bits % 8 != 0) {  // Highest bit first.
      std::uint16_t number = 0;
      for (std::size_t bit = i * format.bits; bit < (i + 1) * format.bits; ++bit) {
        const auto byte = std::to_integer<unsigned>(row[bit / 8]);
        number = static_cast<std::uint16_t>(unsigned{number} << 1 | (byte >> (7 - bit % 8) & 1U));
      }
      std::memcpy(into, &number, width);  // Requires a little-endian host.
    } else if (format.is_half()) {
      std::uint16_t half = 0;
      std::memcpy(&half, row.data() + 2 * i, sizeof(half));
      const float number = float_from_half(half);
      std::memcpy(into, &number, sizeof(number));
    } else {
      std::memcpy(into, row.data() + width * i, width);
    }
  }
}

}  // namespace

struct TiffPages::Reader {
  explicit Reader(const std::filesystem::path& file) {
    TIFFSetErrorHandler(&keep_problem);
    TIFFSetWarningHandler(nullptr);
    tiff_problem.clear();
    tiff = TIFFOpen(file.c_str(), "rm");
  }
  ~Reader() {
    if (tiff != nullptr) TIFFClose(tiff);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  TIFF* tiff = nullptr;
};

namespace {

[[noreturn]] void fail_in_tiff(const std::filesystem::path& file, const std::string& problem) {
  std::string text = problem;
  if (!tiff_problem.empty()) text += " (libtiff: " + tiff_problem + ")";
  while (text.ends_with('.')) text.pop_back();
  for (const char* const lack : {"not implemented", "not configured"}) {
    if (tiff_problem.find(lack) == std::string::npos) continue;
    fail_reading(file, text, "Save it with another compression, or with none");
  }
  fail_damaged(file, text);
}

// Returns the offset of the samples if they are uncompressed, and their strips follow each other.
std::optional<std::uint64_t> plain_offset_of(TIFF* tiff) {
  const PageFormat format = format_of(tiff);
  std::uint64_t* offsets = nullptr;
  if (format.is_tiled || format.is_planar || format.is_upside_down || format.bits % 8 != 0 ||
      format.is_half() ||
      tiff_field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION, 1) != COMPRESSION_NONE ||
      TIFFGetField(tiff, TIFFTAG_STRIPOFFSETS, &offsets) != 1 || offsets == nullptr) {
    return std::nullopt;
  }
  const std::uint64_t rows =
      std::min(tiff_field<std::uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP, format.height), format.height);
  const std::uint64_t strip_bytes = rows * format.row_bytes(format.width);
  const std::uint64_t strips = rows == 0 ? 0 : (format.height - 1) / rows + 1;
  for (std::uint64_t i = 1; i < strips; ++i) {
    if (offsets[i] != offsets[i - 1] + strip_bytes) return std::nullopt;
  }
  return offsets[0];
}

}  // namespace

TiffPages::TiffPages(std::filesystem::path file) : file_(std::move(file)) {
  (void)InputFile(file_);  // Reports errors of the file itself.
  reader_ = std::make_unique<Reader>(file_);
  TIFF* const tiff = reader_->tiff;
  if (tiff == nullptr) fail_in_tiff(file_, "libtiff cannot open it");
  while (true) {
    const auto kind = tiff_field<std::uint32_t>(tiff, TIFFTAG_SUBFILETYPE, 0);
    if ((kind & FILETYPE_REDUCEDIMAGE) == 0) {
      const char* text = nullptr;
      if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr &&
          std::string_view(text).starts_with(R"({"shape":)")) {
        shapes_.push_back({.page = pages_.size(), .text = text});
      }
      pages_.push_back(TIFFCurrentDirOffset(tiff));
    } else {
      has_other_directories_ = true;
    }
    if (TIFFLastDirectory(tiff) != 0) break;
    if (TIFFReadDirectory(tiff) == 0) {
      fail_in_tiff(file_, "its chain of pages leads outside the file or is circular");
    }
  }
  if (pages_.empty()) {
    fail_reading(file_, "it has only reduced copies of pages", "Save it with its full pages");
  }
  select(0);
  char* text = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr) {
    description_ = text;
  }
  resolution_.x = static_cast<double>(tiff_field<float>(tiff, TIFFTAG_XRESOLUTION, 0));
  resolution_.y = static_cast<double>(tiff_field<float>(tiff, TIFFTAG_YRESOLUTION, 0));
  const auto unit = tiff_field<std::uint16_t>(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
  resolution_.unit_mm = unit == RESUNIT_INCH ? 25.4 : unit == RESUNIT_CENTIMETER ? 10 : 0;
  add_metamorph(InputFile(file_), tiff, placement_);
  add_geotiff(tiff, placement_);
  placement_.unread = unread_convention(tiff);
  scaling_ = gdal_scaling(tiff);
  plain_offset_ = plain_offset_of(tiff);
  images_in_first_ = images_in_directory(tiff);
  std::uint16_t count = 0;
  void* sub_directories = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_SUBIFD, &count, &sub_directories) == 1 && count > 0) {
    has_other_directories_ = true;
  }
}

TiffPages::~TiffPages() = default;
TiffPages::TiffPages(TiffPages&&) noexcept = default;
TiffPages& TiffPages::operator=(TiffPages&&) noexcept = default;

bool TiffPages::is_big_endian() const { return TIFFIsBigEndian(reader_->tiff) != 0; }

void TiffPages::select(std::size_t page) const {
  if (TIFFCurrentDirOffset(reader_->tiff) == pages_[page]) return;
  tiff_problem.clear();
  if (TIFFSetSubDirectory(reader_->tiff, pages_[page]) == 0) {
    fail_in_tiff(file_, "its page " + std::to_string(page + 1) + " cannot be read");
  }
}

ImageHeader TiffPages::header(std::size_t page) const {
  select(page);
  const PageFormat format = format_of(reader_->tiff);
  const std::optional<StoredType> type = stored_type_of(format);
  if (!type) {
    const bool is_complex =
        format.kind == SAMPLEFORMAT_COMPLEXINT || format.kind == SAMPLEFORMAT_COMPLEXIEEEFP;
    fail_reading(file_,
                 is_complex ? "its samples are complex numbers"
                            : "its samples have " + std::to_string(format.bits) + " bits",
                 "Save them as integers or floating-point numbers of 8, 16, 32 or 64 bits");
  }
  std::uint16_t unused = 0;
  const bool has_sign = TIFFGetField(reader_->tiff, TIFFTAG_SAMPLEFORMAT, &unused) == 1;
  ImageHeader header{
      .type = *type,
      .values = {Basis::kByFormat, has_sign ? Basis::kStated : Basis::kByFormat, Basis::kByFormat},
      .components = format.components};
  header.dims = {format.width, format.height, 1};
  if (format.kind != SAMPLEFORMAT_IEEEFP) header.stored_bits = format.bits;
  const auto color = tiff_field<std::uint16_t>(reader_->tiff, TIFFTAG_PHOTOMETRIC, 1);
  if (color == PHOTOMETRIC_PALETTE) note_palette(header);
  if (color == PHOTOMETRIC_MINISWHITE) {
    header.contradictions.push_back(
        {Fact::kScaling, "its small numbers are white (WhiteIsZero); they are read as stored"});
  }
  const auto orientation = tiff_field<std::uint16_t>(reader_->tiff, TIFFTAG_ORIENTATION, 1);
  if (orientation != ORIENTATION_TOPLEFT && orientation != ORIENTATION_BOTLEFT) {
    header.contradictions.push_back(
        {Fact::kAxes, "its pages are to be turned or mirrored (Orientation " +
                          std::to_string(orientation) + "); they are read as stored"});
  }
  return header;
}

void TiffPages::read(std::size_t page, std::byte* into) const {
  const ImageHeader image = header(page);
  TIFF* const tiff = reader_->tiff;
  const PageFormat format = format_of(tiff);
  // Converts JPEG's YCbCr colors to red, green and blue.
  if (tiff_field<std::uint16_t>(tiff, TIFFTAG_COMPRESSION, 1) == COMPRESSION_JPEG) {
    (void)TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  }
  tiff_problem.clear();
  // Blocks of rows: tiles, or strips as wide as the page.
  const std::uint32_t block_width =
      format.is_tiled ? tiff_field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH, 0) : format.width;
  const std::uint32_t block_height =
      format.is_tiled
          ? tiff_field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH, 0)
          : std::min(tiff_field<std::uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP, format.height),
                     format.height);
  const tmsize_t block_bytes = format.is_tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
  const std::size_t stored_row = format.row_bytes(block_width);
  if (block_width == 0 || block_height == 0 || block_bytes <= 0 ||
      static_cast<std::size_t>(block_bytes) < stored_row * block_height) {
    fail_in_tiff(file_, "the tiles or strips of its page " + std::to_string(page + 1) +
                            " have an invalid size");
  }
  std::vector<std::byte> block(static_cast<std::size_t>(block_bytes));
  const std::size_t width = bytes_of(image.type);
  const std::size_t pixel = width * format.components;
  const std::size_t planes = format.is_planar ? format.components : 1;
  const std::size_t numbers_in_pixel = format.is_planar ? 1 : format.components;
  std::uint32_t index = 0;
  for (std::size_t plane = 0; plane < planes; ++plane) {
    for (std::uint32_t y = 0; y < format.height; y += block_height) {
      const std::uint32_t rows = std::min(block_height, format.height - y);
      for (std::uint32_t x = 0; x < format.width; x += block_width, ++index) {
        const std::size_t needed = format.is_tiled ? block.size() : stored_row * rows;
        const tmsize_t got =
            format.is_tiled
                ? TIFFReadEncodedTile(tiff, index, block.data(), block_bytes)
                : TIFFReadEncodedStrip(tiff, index, block.data(), static_cast<tmsize_t>(needed));
        if (got < 0 || static_cast<std::size_t>(got) < needed) {
          fail_in_tiff(file_, "its page " + std::to_string(page + 1) + " cannot be read");
        }
        const std::size_t columns = std::min(block_width, format.width - x);
        for (std::uint32_t row = 0; row < rows; ++row) {
          const std::size_t to_row = format.is_upside_down ? format.height - 1 - y - row : y + row;
          unpack_row(format, std::span<const std::byte>(block).subspan(row * stored_row),
                     columns * numbers_in_pixel,
                     into + (to_row * format.width + x) * pixel + plane * width, width,
                     format.is_planar ? pixel : width);
        }
      }
    }
  }
}

}  // namespace multitetra

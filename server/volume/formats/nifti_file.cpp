#include "server/volume/formats/nifti_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kVersion1Bytes = 348;
constexpr std::size_t kVersion2Bytes = 540;

// The header fields in use, of all versions.
struct NiftiHeader {
  std::array<std::int64_t, 8> dim{};
  int type = 0;
  std::array<double, 8> pixdim{};
  double offset = 0;
  double slope = 0;
  double intercept = 0;
  double first_time = 0;
  int units = 0;
  int qform = 0;
  int sform = 0;
  std::array<double, 6> quaternion{};  // b, c, d, then the offset.
  std::array<std::array<double, 4>, 3> rows{};
  bool in_two_files = false;
  bool has_spm_origin = false;  // In the header of Analyze.
};

template <typename Integer, typename Real, typename Code>
void read_fields(const HeaderBytes& bytes, std::array<std::size_t, 9> at, NiftiHeader& header) {
  const auto [dim, pixdim, offset, slope, qform, sform, quaternion, rows, type] = at;
  for (std::size_t i = 0; i < 8; ++i) {
    header.dim[i] = bytes.at<Integer>(dim + i * sizeof(Integer));
    header.pixdim[i] = static_cast<double>(bytes.at<Real>(pixdim + i * sizeof(Real)));
  }
  header.type = bytes.at<std::int16_t>(type);
  header.slope = static_cast<double>(bytes.at<Real>(slope));
  header.intercept = static_cast<double>(bytes.at<Real>(slope + sizeof(Real)));
  header.qform = bytes.at<Code>(qform);
  header.sform = bytes.at<Code>(sform);
  for (std::size_t i = 0; i < 6; ++i) {
    header.quaternion[i] = static_cast<double>(bytes.at<Real>(quaternion + i * sizeof(Real)));
  }
  for (std::size_t i = 0; i < 12; ++i) {
    header.rows[i / 4][i % 4] = static_cast<double>(bytes.at<Real>(rows + i * sizeof(Real)));
  }
  header.offset = sizeof(Real) == 4 ? static_cast<double>(bytes.at<float>(offset))
                                    : static_cast<double>(bytes.at<std::int64_t>(offset));
}

std::optional<Endian> endian_of(std::string_view beginning, std::size_t header_bytes) {
  if (beginning.size() < header_bytes) return std::nullopt;
  for (const Endian endian : {Endian::kLittle, Endian::kBig}) {
    const HeaderBytes bytes(std::string(beginning.substr(0, 4)), endian);
    if (bytes.at<std::int32_t>(0) == static_cast<std::int32_t>(header_bytes)) return endian;
  }
  return std::nullopt;
}

bool is_version_1(std::string_view beginning) {
  if (!endian_of(beginning, kVersion1Bytes)) return false;
  const std::string_view magic = beginning.substr(344, 4);
  return magic == std::string_view("n+1\0", 4) || magic == std::string_view("ni1\0", 4);
}

bool is_version_2(std::string_view beginning) {
  if (!endian_of(beginning, kVersion2Bytes)) return false;
  const std::string_view magic = beginning.substr(4, 4);
  return magic == std::string_view("n+2\0", 4) || magic == std::string_view("ni2\0", 4);
}

// Returns whether the bits of a sample match its type, as in every Analyze header.
bool has_bits_of_its_type(const HeaderBytes& header) {
  constexpr std::array<std::pair<int, int>, 5> kBits = {
      {{2, 8}, {4, 16}, {8, 32}, {16, 32}, {64, 64}}};
  const std::pair<int, int> stated{header.at<std::int16_t>(70), header.at<std::int16_t>(72)};
  return std::find(kBits.begin(), kBits.end(), stated) != kBits.end();
}

// Analyze 7.5 has the same layout without the magic, and always two files. "regular" is 'r';
// nibabel and others leave it 0.
bool is_analyze(std::string_view beginning) {
  const auto endian = endian_of(beginning, kVersion1Bytes);
  if (!endian || is_version_1(beginning)) return false;
  const HeaderBytes bytes(std::string(beginning.substr(0, kVersion1Bytes)), *endian);
  const bool is_marked =
      beginning[38] == 'r' || (beginning[38] == 0 && has_bits_of_its_type(bytes));
  return is_marked && bytes.at<std::int16_t>(40) >= 1 && bytes.at<std::int16_t>(40) <= 7;
}

NiftiHeader header_in(const std::string& beginning) {
  NiftiHeader header;
  if (is_analyze(beginning)) {
    const HeaderBytes bytes(beginning, *endian_of(beginning, kVersion1Bytes));
    for (std::size_t i = 0; i < 8; ++i) {
      header.dim[i] = bytes.at<std::int16_t>(40 + 2 * i);
      header.pixdim[i] = static_cast<double>(bytes.at<float>(76 + 4 * i));
    }
    header.type = bytes.at<std::int16_t>(70);
    header.offset = std::abs(static_cast<double>(bytes.at<float>(108)));
    header.slope = static_cast<double>(bytes.at<float>(112));  // Of SPM; unused by others.
    header.units = 2;                                          // mm
    header.has_spm_origin = bytes.at<std::int16_t>(253) != 0 || bytes.at<std::int16_t>(255) != 0;
    header.in_two_files = true;
  } else if (is_version_1(beginning)) {
    const HeaderBytes bytes(beginning, *endian_of(beginning, kVersion1Bytes));
    read_fields<std::int16_t, float, std::int16_t>(
        bytes, {40, 76, 108, 112, 252, 254, 256, 280, 70}, header);
    header.units = bytes.at<std::uint8_t>(123);
    header.first_time = static_cast<double>(bytes.at<float>(136));
    header.in_two_files = beginning[345] == 'i';
  } else {
    const HeaderBytes bytes(beginning, *endian_of(beginning, kVersion2Bytes));
    read_fields<std::int64_t, double, std::int32_t>(
        bytes, {16, 104, 168, 176, 344, 348, 352, 400, 12}, header);
    header.units = bytes.at<std::int32_t>(500);
    header.first_time = bytes.at<double>(216);
    header.in_two_files = beginning[5] == 'i';
  }
  return header;
}

struct NumberType {
  int code;
  StoredType type;
  int components;
};

NumberType number_type(const fs::path& file, int code) {
  constexpr std::array<NumberType, 12> kTypes = {{{2, StoredType::kU8, 1},
                                                  {4, StoredType::kI16, 1},
                                                  {8, StoredType::kI32, 1},
                                                  {16, StoredType::kF32, 1},
                                                  {64, StoredType::kF64, 1},
                                                  {128, StoredType::kU8, 3},
                                                  {256, StoredType::kI8, 1},
                                                  {512, StoredType::kU16, 1},
                                                  {768, StoredType::kU32, 1},
                                                  {1024, StoredType::kI64, 1},
                                                  {1280, StoredType::kU64, 1},
                                                  {2304, StoredType::kU8, 4}}};
  for (const NumberType& type : kTypes) {
    if (type.code == code) return type;
  }
  const bool is_complex = code == 32 || code == 1792 || code == 2048;
  fail_reading(file,
               "its datatype is " + std::to_string(code) + (is_complex ? ", complex numbers" : ""),
               "Give integers of 8 to 64 bits, floats of 32 or 64 bits, or RGB");
}

// The steps between samples and the position of the first one, in RAS.
struct Axes {
  std::array<Vec3, 3> steps;
  Vec3 origin;
};

Axes axes_of_sform(const NiftiHeader& header) {
  Axes axes{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) axes.steps[axis][row] = header.rows[row][axis];
    axes.origin[row] = header.rows[row][3];
  }
  return axes;
}

Axes axes_of_qform(const NiftiHeader& header) {
  auto [b, c, d, x, y, z] = header.quaternion;
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // Half turn: rounding must not change it.
    const double length = std::sqrt(b * b + c * c + d * d);
    if (length > 0) {
      b /= length;
      c /= length;
      d /= length;
    }
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const std::array<Vec3, 3> columns = {
      Vec3{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)},
      Vec3{2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)},
      Vec3{2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c}};
  Axes axes{.steps = {}, .origin = {x, y, z}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double step = std::abs(header.pixdim[axis + 1]);  // Only pixdim[0] mirrors, as niftilib has it.
    if (axis == 2 && header.pixdim[0] < 0) step = -step;
    for (std::size_t row = 0; row < 3; ++row) axes.steps[axis][row] = columns[axis][row] * step;
  }
  return axes;
}

// Returns by how much both place a corner of the grid differently, in steps of the smallest
// spacing.
double disagreement(const NiftiHeader& nifti, const Axes& a, const Axes& b) {
  double largest = 0;
  double spacing = length(a.steps[0]);
  for (std::size_t axis = 1; axis < 3; ++axis) spacing = std::min(spacing, length(a.steps[axis]));
  for (std::size_t corner = 0; corner < 8; ++corner) {
    Vec3 off = difference(a.origin, b.origin);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1U) == 0) continue;
      const double steps = static_cast<double>(nifti.dim[axis + 1] - 1);
      off = moved(off, steps, difference(a.steps[axis], b.steps[axis]));
    }
    largest = std::max(largest, length(off));
  }
  return largest / spacing;
}

// Notes that one of two placements of the same space is used. With other codes, they are places in
// two spaces, such as those of the scanner and of an atlas.
void note_disagreement(const NiftiHeader& nifti, bool is_sform_used, ImageHeader& header) {
  if (!is_sform_used) {
    header.contradictions.push_back(
        {Fact::kAxes, "its sform is sheared; the qform is used. --resample uses the sform"});
  } else if (nifti.sform == nifti.qform) {
    const double steps = disagreement(nifti, axes_of_sform(nifti), axes_of_qform(nifti));
    if (!(steps > 0.5)) return;
    header.contradictions.push_back({Fact::kOrigin, "its sform and qform place it up to " +
                                                        rounded_text(steps) +
                                                        " voxels apart; the sform is used"});
  }
}

bool has_steps(const Axes& axes) {
  return std::all_of(axes.steps.begin(), axes.steps.end(),
                     [](const Vec3& step) { return length(step) > 0; });
}

// A sheared sform, as from registration, gives way to the qform, unless the grid is `resampled`.
void place(const NiftiHeader& nifti, bool resampled, ImageHeader& header) {
  const int unit = nifti.units & 7;
  header.meaning.length_unit = unit == 1 ? "m" : unit == 2 ? "mm" : unit == 3 ? "µm" : "";
  if (nifti.sform <= 0 && nifti.qform <= 0) {
    StatedNumbers spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) spacing[axis] = std::abs(nifti.pixdim[axis + 1]);
    return set_box_axes(header, kNotStated, spacing);
  }
  header.meaning.space = WorldSpace::kLps;
  if (header.meaning.length_unit.empty()) header.meaning.length_unit = "mm";
  const auto set = [&](Axes axes) {
    ras_to_lps(header, axes.steps, axes.origin);
    set_axes(header, axes.steps, stated(axes.origin));
  };
  const bool is_empty = nifti.sform > 0 && nifti.qform > 0 && !has_steps(axes_of_sform(nifti));
  if (is_empty) {
    header.contradictions.push_back(
        {Fact::kAxes, "its sform has an axis without length; the qform is used"});
    return set(axes_of_qform(nifti));
  }
  if (nifti.sform > 0) set(axes_of_sform(nifti));
  const bool is_usable = nifti.sform > 0 && (resampled || has_right_angles(header));
  if (nifti.qform > 0 && !is_usable) set(axes_of_qform(nifti));
  if (nifti.qform > 0 && nifti.sform > 0) note_disagreement(nifti, is_usable, header);
}

// The fourth axis may also contain frequencies.
SourceTimes times_of(const NiftiHeader& nifti, std::int64_t count) {
  const int unit = nifti.units & 0x38;
  return even_times(count, nifti.first_time, nifti.pixdim[4],
                    unit == 8    ? "s"
                    : unit == 16 ? "ms"
                    : unit == 24 ? "µs"
                    : unit == 32 ? "Hz"
                    : unit == 40 ? "ppm"
                    : unit == 48 ? "rad/s"
                                 : "");
}

// Returns the length of a dimension, at least 1.
std::int64_t length_along(const fs::path& file, const NiftiHeader& nifti, std::int64_t dimension) {
  const std::int64_t length =
      dimension <= nifti.dim[0] ? nifti.dim[static_cast<std::size_t>(dimension)] : 1;
  if (length < 0) {
    fail_reading(file, "its dimensions are negative", "Check the program that wrote it");
  }
  return std::max<std::int64_t>(length, 1);
}

// Returns the file with the samples of a header.
fs::path image_file(const fs::path& header, bool allow_external_files) {
  const fs::path stem = header.extension() == ".gz" ? header.stem().stem() : header.stem();
  const bool packed =
      header.extension() == ".gz" || !fs::exists(header.parent_path() / (stem.string() + ".img"));
  return named_data_file(header, stem.string() + (packed ? ".img.gz" : ".img"),
                         allow_external_files);
}

}  // namespace

bool is_nifti(std::string_view beginning) {
  return is_version_1(beginning) || is_version_2(beginning) || is_analyze(beginning);
}

std::optional<fs::path> nifti_header_of(const fs::path& image) {
  const fs::path packed_stem = image.extension() == ".gz" ? image.stem() : image.filename();
  if (packed_stem.extension() != ".img") return std::nullopt;
  std::error_code error;
  for (const char* suffix : {".hdr", ".hdr.gz"}) {
    const fs::path header = image.parent_path() / (packed_stem.stem().string() + suffix);
    if (fs::is_regular_file(header, error) &&
        is_nifti(unpacked_beginning(InputFile(header), kVersion2Bytes))) {
      return header;
    }
  }
  return std::nullopt;
}

StoredVolume open_nifti(const fs::path& given, const VolumeChoice& choice) {
  const fs::path path = nifti_header_of(given).value_or(given);
  const std::string beginning = unpacked_beginning(InputFile(path), kVersion2Bytes);
  if (!is_nifti(beginning)) {
    fail_reading(path, "it is not a NIfTI file", "Check its name and the program that wrote it");
  }
  const NiftiHeader nifti = header_in(beginning);
  const Endian endian = is_version_2(beginning) ? *endian_of(beginning, kVersion2Bytes)
                                                : *endian_of(beginning, kVersion1Bytes);
  if (nifti.dim[0] < 2 || nifti.dim[0] > 7) {
    fail_reading(path, "it has " + std::to_string(nifti.dim[0]) + " dimensions", "Give 2 to 5");
  }
  const NumberType type = number_type(path, nifti.type);
  ImageHeader header{.type = type.type, .values = kNumbersAsStored, .components = type.components};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.dims[axis] = static_cast<std::int64_t>(axis) < nifti.dim[0] ? nifti.dim[axis + 1] : 1;
  }
  if (std::isfinite(nifti.slope) && nifti.slope != 0 && type.components == 1) {
    header.slope = nifti.slope;
    header.intercept = std::isfinite(nifti.intercept) ? nifti.intercept : 0;
    if (!std::isfinite(nifti.intercept)) {
      header.contradictions.push_back(
          {Fact::kScaling, "its intercept (scl_inter) is not a number; 0 is used"});
    }
    header.values.scaling = Basis::kStated;
    if (is_analyze(beginning) && nifti.slope != 1) {
      header.contradictions.push_back({Fact::kScaling, "its Analyze header has the scale factor " +
                                                           rounded_text(nifti.slope) +
                                                           ", as SPM writes it; it is applied"});
    }
  }
  if (nifti.has_spm_origin) {
    header.contradictions.push_back(
        {Fact::kOrigin, "its Analyze header has an origin of SPM, which is not read"});
  }
  place(nifti, choice.resample, header);
  for (const std::int64_t dimension : {6, 7}) {
    if (length_along(path, nifti, dimension) == 1) continue;
    fail_reading(path, "it has " + std::to_string(nifti.dim[0]) + " dimensions",
                 "Give at most five");
  }
  // The fifth dimension contains components, each stored as a series of volumes.
  const std::int64_t volumes = length_along(path, nifti, 5);
  const ImageHeader one = header;
  header.components *= std::min(volumes, kMaxComponents + 1);
  check_header(path, header);
  std::vector<std::string> notices;
  if ((nifti.units & 7) == 0 && !header.meaning.length_unit.empty() && !choice.given.length_unit) {
    notices.push_back("'" + path.string() +
                      "': the file states no unit of lengths; mm is assumed. Give it with "
                      "--length-unit.");
  }
  const VolumeContents contents{.times = times_of(nifti, length_along(path, nifti, 4))};
  const std::int64_t time = chosen_time(path, contents.times.count, choice);
  constexpr double kMaxOffset = 1e15;
  const double least = nifti.in_two_files        ? 0
                       : is_version_1(beginning) ? kVersion1Bytes
                                                 : kVersion2Bytes;
  if (!(nifti.offset >= least && nifti.offset < kMaxOffset)) {
    fail_reading(path, "its samples begin at byte " + std::to_string(nifti.offset),
                 "Check the program that wrote it");
  }
  const fs::path data = nifti.in_two_files ? image_file(path, choice.allow_external_files) : path;
  std::vector<std::unique_ptr<StoredSlices>> slices;
  for (std::int64_t i = 0; i < volumes; ++i) {
    const auto before =
        (static_cast<std::uint64_t>(time) +
         static_cast<std::uint64_t>(i) * static_cast<std::uint64_t>(contents.times.count)) *
        one.volume_bytes();
    const std::uint64_t all = static_cast<std::uint64_t>(volumes * contents.times.count);
    slices.push_back(slices_in_file(data, static_cast<std::uint64_t>(nifti.offset) + before, endian,
                                    one, (all - 1) * one.volume_bytes() - before));
  }
  return {
      .header = header,
      .slices = volumes == 1 ? std::move(slices[0]) : interleaved_slices(std::move(slices), header),
      .notices = std::move(notices),
      .contents = contents};
}

}  // namespace multitetra

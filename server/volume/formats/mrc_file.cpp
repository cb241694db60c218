#include "server/volume/formats/mrc_file.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/contour_level.hpp"
#include "server/volume/formats/detail/half_floats.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMrcHeaderBytes = 1024;
constexpr std::int32_t kHalfMode = 12;  // 16-bit floats.

StoredType type_of_mode(const fs::path& file, std::int32_t mode) {
  if (mode == 0) return StoredType::kI8;
  if (mode == 1) return StoredType::kI16;
  if (mode == 2) return StoredType::kF32;
  if (mode == 6) return StoredType::kU16;
  if (mode == kHalfMode) return StoredType::kF32;
  const bool is_complex = mode == 3 || mode == 4;
  fail_reading(file,
               "its mode is " + std::to_string(mode) + (is_complex ? ", complex numbers" : ""),
               "Supported modes are 0, 1, 2, 6 and 12; save it as mode 2");
}

// The numbers of the header, at their byte offsets.
class MrcHeader {
 public:
  explicit MrcHeader(const std::string& bytes) : bytes_(bytes, endian_of(bytes)) {}

  [[nodiscard]] static Endian endian_of(const std::string& bytes) {
    return bytes[212] == 0x11 ? Endian::kBig : Endian::kLittle;
  }
  [[nodiscard]] std::int32_t integer(std::size_t at) const { return bytes_.at<std::int32_t>(at); }
  [[nodiscard]] double real(std::size_t at) const { return bytes_.at<float>(at); }

 private:
  HeaderBytes bytes_;
};

// Sets whether integers have signs. Mode 0 was unsigned before 2014 and in IMOD, which marks its
// files; other files tell by the range of their samples.
void set_sign(const MrcHeader& mrc, ImageHeader& header) {
  constexpr std::int32_t kImodStamp = 1146047817;
  constexpr std::int32_t kImodSignedBytes = 1;
  const bool are_bytes = header.type == StoredType::kI8;
  if (!are_bytes && header.type != StoredType::kI16) return;
  const StoredType without_sign = are_bytes ? StoredType::kU8 : StoredType::kU16;
  const double low = mrc.real(76);
  const double high = mrc.real(80);
  const double most = are_bytes ? 127 : 32767;
  const bool needs_unsigned = low >= 0 && high > most && high <= 2 * most + 1;
  if (are_bytes && mrc.integer(152) == kImodStamp) {
    header.values.sign = Basis::kStated;
    const bool is_signed = (mrc.integer(156) & kImodSignedBytes) != 0;
    if (!is_signed) header.type = without_sign;
    if (is_signed ? !needs_unsigned : !(low < 0 && low <= high)) return;
    header.contradictions.push_back(
        {Fact::kSign, std::string("its flag of IMOD says that bytes are ") +
                          (is_signed ? "signed" : "unsigned") + ", but its header's range is " +
                          rounded_text(low) + " to " + rounded_text(high) + "; the flag is used"});
    return;
  }
  if (!needs_unsigned) return;
  header.type = without_sign;
  header.contradictions.push_back(
      {Fact::kSign, "its mode means signed integers, but its header's range, " + rounded_text(low) +
                        " to " + rounded_text(high) +
                        ", needs unsigned ones; unsigned ones are used"});
}

// Returns the edges of the cell, of which the first is along x and the second in the plane x, y.
std::array<Vec3, 3> cell_edges(const MrcHeader& mrc) {
  std::array<double, 3> cosine{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double angle = mrc.real(52 + 4 * axis);
    const bool is_right = angle == 90 || angle == 0;
    cosine[axis] = is_right ? 0 : std::cos(angle * std::numbers::pi / 180);
  }
  const auto [alpha, beta, gamma] = cosine;
  const double sine = std::sqrt(1 - gamma * gamma);
  const double along_y = (alpha - beta * gamma) / sine;
  const std::array<Vec3, 3> directions = {
      Vec3{1, 0, 0},
      {gamma, sine, 0},
      {beta, along_y, std::sqrt(1 - beta * beta - along_y * along_y)}};
  std::array<Vec3, 3> edges{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = mrc.real(40 + 4 * axis);
    if (length > 0) edges[axis] = scaled(directions[axis], length);
  }
  return edges;
}

// Sets the axes: those of columns, rows and sections are each an axis of the cell.
void place_mrc(const fs::path& file, const MrcHeader& mrc, ImageHeader& header) {
  const std::array<Vec3, 3> edges = cell_edges(mrc);
  std::array<Vec3, 3> steps{};
  Vec3 start{};
  bool is_start_known = true;
  int seen = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t number = mrc.integer(64 + 4 * axis);
    const std::size_t along =
        number >= 1 && number <= 3 ? static_cast<std::size_t>(number - 1) : axis;
    seen |= 1 << along;
    const std::int32_t intervals = mrc.integer(28 + 4 * along);
    if (intervals > 0) steps[axis] = scaled(edges[along], 1.0 / intervals);
    const std::int32_t first = mrc.integer(16 + 4 * axis);
    start = moved(start, first, steps[axis]);
    is_start_known = is_start_known && (first == 0 || length(steps[axis]) > 0);
  }
  if (seen != 7) {
    fail_reading(file, "two of its axes have the same direction",
                 "Correct MAPC, MAPR and MAPS in the header: 1, 2 and 3 in any order");
  }
  const Vec3 origin = {mrc.real(196), mrc.real(200), mrc.real(204)};
  const bool has_origin = origin != Vec3{0, 0, 0};
  set_axes(header, steps,
           has_origin       ? stated(origin)
           : is_start_known ? stated(start)
                            : kNotStated);
}

// Returns the number of volumes in a stack, which has sections of all: space groups 401 to 630.
std::int64_t volumes_in(const MrcHeader& mrc, ImageHeader& header) {
  const std::int32_t group = mrc.integer(88);
  const std::int64_t sections = mrc.integer(36);
  if (group == 0 && sections == 1 && header.dims[2] > 1) {
    header.contradictions.push_back(
        {Fact::kAxes, "its header says that it is a stack of " + std::to_string(header.dims[2]) +
                          " images (ISPG 0, MZ 1); they are read as slices of a volume"});
  }
  if (group < 401 || group > 630 || sections < 1) return 1;
  if (header.dims[2] % sections != 0) {
    header.contradictions.push_back(
        {Fact::kAxes, "its header says that it is a stack of volumes of " +
                          std::to_string(sections) + " sections, but it has " +
                          std::to_string(header.dims[2]) + "; it is read as one volume"});
    return 1;
  }
  const std::int64_t volumes = header.dims[2] / sections;
  header.dims[2] = sections;
  return volumes;
}

}  // namespace

bool is_mrc(std::string_view beginning) {
  return beginning.size() >= 212 && beginning.substr(208, 4) == "MAP ";
}

StoredVolume open_mrc(const fs::path& path, const VolumeChoice& choice) {
  const std::string beginning = unpacked_beginning(InputFile(path), kMrcHeaderBytes);
  if (beginning.size() < kMrcHeaderBytes) fail_incomplete(path, "it ends within its header");
  const MrcHeader mrc(beginning);
  const std::int32_t mode = mrc.integer(12);
  StoredVolume volume{.header = {.type = type_of_mode(path, mode),
                                 .values = {Basis::kByFormat, Basis::kByFormat, Basis::kByFormat},
                                 .meaning = {.length_unit = "Å", .value_unit = {}}}};
  ImageHeader& header = volume.header;
  for (std::size_t axis = 0; axis < 3; ++axis) header.dims[axis] = mrc.integer(4 * axis);
  set_sign(mrc, header);
  place_mrc(path, mrc, header);
  volume.contents.times.count = volumes_in(mrc, header);
  check_header(path, header);
  const std::int32_t extended = mrc.integer(92);
  if (extended < 0) {
    fail_reading(path, "its extended header has a negative length", "Correct NSYMBT in the header");
  }
  const std::int64_t time = chosen_time(path, volume.contents.times.count, choice);
  const auto volume_bytes = header.volume_bytes() / (mode == kHalfMode ? 2 : 1);
  const std::uint64_t offset = kMrcHeaderBytes + static_cast<std::uint64_t>(extended) +
                               static_cast<std::uint64_t>(time) * volume_bytes;
  const auto behind =
      static_cast<std::uint64_t>(volume.contents.times.count - 1 - time) * volume_bytes;
  const Endian endian = MrcHeader::endian_of(beginning);
  volume.contents.recommended_isovalue = sidecar_contour_level(path);
  ImageHeader stored = header;
  if (mode == kHalfMode) stored.type = StoredType::kU16;
  volume.slices = slices_in_file(path, offset, endian, stored, behind);
  if (mode == kHalfMode) volume.slices = slices_of_halves(std::move(volume.slices), header);
  return volume;
}

}  // namespace multitetra

#include "server/volume/formats/npy_file.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "common/base/parse_number.hpp"
#include "server/volume/formats/detail/half_floats.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

struct NpyType {
  std::string_view name;
  StoredType type;
  bool are_halves = false;
};

constexpr std::array<NpyType, 12> kNpyTypes = {{{"u1", StoredType::kU8},
                                                {"b1", StoredType::kU8},
                                                {"i1", StoredType::kI8},
                                                {"u2", StoredType::kU16},
                                                {"i2", StoredType::kI16},
                                                {"f2", StoredType::kF32, true},
                                                {"f4", StoredType::kF32},
                                                {"u4", StoredType::kU32},
                                                {"i4", StoredType::kI32},
                                                {"u8", StoredType::kU64},
                                                {"i8", StoredType::kI64},
                                                {"f8", StoredType::kF64}}};

// Returns what follows 'key': in the header, a Python literal; empty if it is missing.
std::string_view behind_key(std::string_view header, std::string_view key) {
  const std::size_t at = header.find("'" + std::string(key) + "':");
  if (at == std::string_view::npos) return {};
  std::string_view rest = header.substr(at + key.size() + 3);
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  return rest;
}

std::vector<std::int64_t> shape_in(std::string_view text) {
  std::vector<std::int64_t> shape;
  if (!text.starts_with('(')) return shape;
  text.remove_prefix(1);
  while (shape.size() < 8) {
    text.remove_prefix(std::min(text.find_first_not_of(", "), text.size()));
    const auto length = take_number<std::int64_t>(text);
    if (!length) return text.starts_with(')') ? shape : std::vector<std::int64_t>();
    shape.push_back(*length);
  }
  return {};
}

}  // namespace

bool is_npy(std::string_view beginning) { return beginning.starts_with("\x93NUMPY"); }

StoredVolume open_npy(const fs::path& path, const VolumeChoice& choice) {
  constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 16;
  const std::string beginning = unpacked_beginning(InputFile(path), kMaxHeaderBytes);
  if (!is_npy(beginning) || beginning.size() < 12) {
    fail_reading(path, "it is not a NumPy array", "Check its name and the program that wrote it");
  }
  const HeaderBytes bytes(beginning.substr(0, 12), Endian::kLittle);
  const bool is_short = beginning[6] == 1;
  const std::uint64_t text_at = is_short ? 10 : 12;
  const std::uint64_t length = is_short ? bytes.at<std::uint16_t>(8) : bytes.at<std::uint32_t>(8);
  if (text_at + length > beginning.size()) {
    fail_incomplete(path, "it ends within its header");
  }
  const std::string_view text = std::string_view(beginning).substr(text_at, length);
  const std::string_view descr = behind_key(text, "descr");
  const std::vector<std::int64_t> shape = shape_in(behind_key(text, "shape"));
  const NpyType* found = nullptr;
  for (const NpyType& type : kNpyTypes) {
    if (descr.size() > 5 && descr[0] == '\'' && descr[4] == '\'' && descr.substr(2, 2) == type.name)
      found = &type;
  }
  if (found == nullptr) {
    fail_reading(path, "its numbers have the type " + std::string(descr.substr(0, descr.find(','))),
                 "Save integers of 8 to 64 bits or floats of 16 to 64");
  }
  if (shape.size() < 2 || shape.size() > 4) {
    fail_reading(path, "it has " + std::to_string(shape.size()) + " dimensions", "Save 2 to 4");
  }
  const bool is_fortran = behind_key(text, "fortran_order").starts_with("True");
  if (is_fortran && shape.size() == 4) {
    fail_reading(path, "its four dimensions are in Fortran order",
                 "Save numpy.ascontiguousarray(array)");
  }
  ImageHeader header{.type = found->type, .values = kNumbersAsStored};
  const std::size_t spatial = std::min<std::size_t>(shape.size(), 3);
  for (std::size_t axis = 0; axis < spatial; ++axis) {
    const std::size_t d = is_fortran ? axis : shape.size() - 1 - axis;
    header.dims[axis] = shape[d];
    if (!is_fortran) continue;
    header.geometry.axes[axis] = {0, 0, 0};
    header.geometry.axes[axis][spatial - 1 - axis] = 1;
  }
  check_header(path, header);
  VolumeContents contents;
  std::int64_t time = 0;
  if (shape.size() == 4) {
    contents.times.count = shape[0];
    time = chosen_time(path, shape[0], choice);
  }
  const std::uint64_t number_bytes = found->are_halves ? 2 : bytes_of(header.type);
  const std::uint64_t volume_bytes = header.volume_bytes() / bytes_of(header.type) * number_bytes;
  const std::uint64_t offset = text_at + length + static_cast<std::uint64_t>(time) * volume_bytes;
  const std::uint64_t behind =
      static_cast<std::uint64_t>(contents.times.count - 1 - time) * volume_bytes;
  const Endian endian = descr[1] == '>' ? Endian::kBig : Endian::kLittle;
  auto slices = found->are_halves ? halves_in_file(path, offset, endian, header)
                                  : slices_in_file(path, offset, endian, header, behind);
  return {.header = header, .slices = std::move(slices), .contents = std::move(contents)};
}

}  // namespace multitetra

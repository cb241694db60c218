#include "server/volume/formats/npy_file.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/parse_number.hpp"
#include "server/volume/formats/arrays/array_volume.hpp"
#include "server/volume/formats/detail/half_floats.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/zip_store.hpp"

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

// An array, in the order of the file: slowest dimension first.
struct NpyArray {
  std::vector<std::int64_t> shape;
  std::string descr;              // Its type, as NumPy writes it.
  const NpyType* type = nullptr;  // Null if that is not one of numbers.
  bool is_fortran = false;
  std::uint64_t begin = 0;  // Of the samples in the file.
  std::string entry = {};   // Its file in an archive.
};

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 16;

NpyArray array_with(const fs::path& path, const std::string& beginning) {
  if (!is_npy(beginning) || beginning.size() < 12) {
    fail_reading(path, "it is not a NumPy array", "Check its name and the program that wrote it");
  }
  const HeaderBytes bytes(beginning.substr(0, 12), Endian::kLittle);
  const bool is_short = beginning[6] == 1;
  const std::uint64_t text_at = is_short ? 10 : 12;
  const std::uint64_t length = is_short ? bytes.at<std::uint16_t>(8) : bytes.at<std::uint32_t>(8);
  if (text_at + length > beginning.size()) fail_incomplete(path, "it ends within its header");
  const std::string_view text = std::string_view(beginning).substr(text_at, length);
  const std::string_view descr = behind_key(text, "descr");
  NpyArray array{.shape = shape_in(behind_key(text, "shape")),
                 .descr = std::string(descr.substr(0, descr.find(','))),
                 .is_fortran = behind_key(text, "fortran_order").starts_with("True"),
                 .begin = text_at + length};
  for (const NpyType& type : kNpyTypes) {
    if (descr.size() > 5 && descr[0] == '\'' && descr[4] == '\'' && descr.substr(2, 2) == type.name)
      array.type = &type;
  }
  if (array.is_fortran) std::reverse(array.shape.begin(), array.shape.end());
  return array;
}

// The array of a .npy file, or those of an .npz file by the names that numpy.load has for them.
class NpyArrays : public ArrayContainer {
 public:
  explicit NpyArrays(const fs::path& path) : path_(path) {
    const std::string beginning = unpacked_beginning(InputFile(path), kMaxHeaderBytes);
    if (!is_zip(beginning)) {
      all_["/" + path.stem().string()] = array_with(path, beginning);
      return;
    }
    add_entries(*zip_store(path), "", 0);
  }

  [[nodiscard]] const NpyArray& at(const std::string& name) const {
    if (const auto found = all_.find(name); found != all_.end()) return found->second;
    std::string names;
    for (const auto& [other, array] : all_) {
      if (names.size() < 600) names += (names.empty() ? "" : ", ") + other.substr(1);
    }
    fail_reading(path_, "it has no array '" + name.substr(1) + "'", "Its arrays are " + names);
  }

  [[nodiscard]] fs::path file() const override { return path_; }
  [[nodiscard]] std::vector<std::string> arrays() const override {
    std::vector<std::string> names;
    for (const auto& [name, array] : all_) {
      const bool is_one =
          std::ranges::count_if(array.shape, [](auto side) { return side > 1; }) > 1;
      if (all_.size() == 1 || (array.type != nullptr && is_one)) names.push_back(name);
    }
    return names;
  }
  [[nodiscard]] std::vector<std::int64_t> shape(const std::string& name) const override {
    const auto found = all_.find(name);
    return found == all_.end() ? std::vector<std::int64_t>() : found->second.shape;
  }
  [[nodiscard]] std::optional<StoredType> type(const std::string& name) const override {
    const NpyType* const type = at(name).type;
    return type == nullptr ? std::nullopt : std::optional(type->type);
  }

 private:
  // Adds the arrays of a folder in an archive.
  void add_entries(ObjectStore& archive, const std::string& folder, int depth) {
    constexpr int kDeepest = 8;
    for (const std::string& inside : archive.names(folder)) {
      const std::string name = folder + inside;
      const bool is_array = name.ends_with(".npy") && all_.size() < kMaxSourceMembers;
      const auto bytes = is_array ? archive.get_range(name, 0, kMaxHeaderBytes) : std::nullopt;
      if (bytes) {
        NpyArray array = array_with(
            path_ / name, std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
        array.entry = name;
        all_["/" + name.substr(0, name.size() - 4)] = std::move(array);
      } else if (depth < kDeepest) {
        add_entries(archive, name + "/", depth + 1);
      }
    }
  }

  fs::path path_;
  std::map<std::string, NpyArray> all_;
};

// The fastest dimension of an array in Fortran order is its first one, the world's z.
void set_fortran_axes(const NpyArray& array, ImageHeader& header) {
  const std::size_t spatial = std::min<std::size_t>(array.shape.size(), 3);
  for (std::size_t axis = 0; array.is_fortran && axis < spatial; ++axis) {
    header.geometry.axes[axis] = {0, 0, 0};
    header.geometry.axes[axis][spatial - 1 - axis] = 1;
  }
}

}  // namespace

bool is_npy(std::string_view beginning) { return beginning.starts_with("\x93NUMPY"); }

StoredVolume open_npy(const fs::path& path, const VolumeChoice& choice) {
  const NpyArrays file(path);
  if (file.arrays().empty()) {
    fail_reading(path, "it has no array of numbers with two or more dimensions", "Save one");
  }
  const std::string name = chosen_array(file, choice);
  const NpyArray& array = file.at(name);
  if (array.type == nullptr) {
    fail_reading(path, "its numbers have the type " + array.descr,
                 "Save integers of 8 to 64 bits or floats of 16 to 64");
  }
  if (array.is_fortran && array.shape.size() > 3) {
    fail_reading(path, "its dimensions are more than three and in Fortran order",
                 "Save numpy.ascontiguousarray(array)");
  }
  ArrayMeaning meaning{.roles = roles_by_place(array.shape),
                       .are_roles_by_place = true,
                       .header = {.values = kNumbersAsStored}};
  set_fortran_axes(array, meaning.header);
  VolumeInArray place;
  StoredVolume volume =
      described_volume(file, name, std::move(meaning), choice, /*has_components=*/true, place);
  if (choice.first) list_arrays(file, name, volume.contents);
  const bool are_halves = array.type->are_halves;
  ImageHeader stored = volume.header;
  if (are_halves) stored.type = StoredType::kU16;
  std::uint64_t before = 0;  // Numbers before those of the volume, whose dimensions are the last.
  std::uint64_t all = 1;
  for (std::size_t d = 0; d < array.shape.size(); ++d) {
    before = before * static_cast<std::uint64_t>(array.shape[d]) +
             static_cast<std::uint64_t>(place.at[d]);
    all *= static_cast<std::uint64_t>(array.shape[d]);
  }
  before *= bytes_of(stored.type);
  const std::uint64_t offset = array.begin + before;
  const std::uint64_t behind = all * bytes_of(stored.type) - before - stored.volume_bytes();
  const Endian endian = array.descr[1] == '>' ? Endian::kBig : Endian::kLittle;
  volume.slices = array.entry.empty() ? slices_in_file(path, offset, endian, stored, behind)
                                      : slices_in_zip(path, array.entry, offset, endian, stored);
  if (are_halves) volume.slices = slices_of_halves(std::move(volume.slices), volume.header);
  return volume;
}

}  // namespace multitetra

#include "server/volume/formats/cube_file.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/text_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;
constexpr std::int64_t kMaxAtoms = 100'000;

// The four lines of the grid: each has a count and a position or step.
struct CubeGrid {
  std::int64_t atoms = 0;  // Negative if a line about orbitals follows the atoms.
  std::int64_t components = 1;
  Vec3 origin{};
  std::array<std::int64_t, 3> counts{};  // Negative if lengths are in Å.
  std::array<Vec3, 3> steps{};
};

std::optional<CubeGrid> grid_in(std::string_view& text) {
  take_line(text);
  take_line(text);
  CubeGrid grid;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<double> numbers = finite_numbers(std::string(take_line(text)));
    if (numbers.size() < 4 || numbers.size() > 5 || numbers[0] != std::round(numbers[0]) ||
        std::abs(numbers[0]) > 1e9) {
      return std::nullopt;
    }
    const auto count = static_cast<std::int64_t>(numbers[0]);
    const Vec3 vector = {numbers[1], numbers[2], numbers[3]};
    if (i == 0) {
      grid.atoms = count;
      grid.origin = vector;
      if (numbers.size() == 5 && (numbers[4] < 1 || numbers[4] > kMaxComponents))
        return std::nullopt;
      if (numbers.size() == 5) grid.components = static_cast<std::int64_t>(numbers[4]);
    } else {
      if (count == 0) return std::nullopt;
      grid.counts[i - 1] = count;
      grid.steps[i - 1] = vector;
    }
  }
  return grid;
}

}  // namespace

bool is_cube(std::string_view beginning) { return grid_in(beginning).has_value(); }

StoredVolume open_cube(const fs::path& path) {
  const InputFile file(path);
  const Packing packing = UnpackedStream::packing_at(file, 0);
  const bool is_packed = packing == Packing::kGzip || packing == Packing::kBzip2;
  const std::string beginning = unpacked_beginning(file, kMaxHeaderBytes);
  std::string_view rest = beginning;
  const std::optional<CubeGrid> grid = grid_in(rest);
  if (!grid)
    fail_reading(path, "it is not a cube file", "Check its name and the program that wrote it");
  if (std::abs(grid->atoms) > kMaxAtoms) {
    fail_reading(path, "it has " + std::to_string(grid->atoms) + " atoms",
                 "Check the program that wrote it");
  }
  for (std::int64_t i = 0; i < std::abs(grid->atoms); ++i) {
    if (finite_numbers(std::string(take_line(rest))).size() != 5) {
      fail_damaged(path,
                   "the line of its atom " + std::to_string(i + 1) + " does not have five numbers");
    }
  }
  std::int64_t components = grid->components;
  if (grid->atoms < 0) {  // Number of orbitals, followed by their numbers.
    std::vector<double> orbitals = finite_numbers(std::string(take_line(rest)));
    while (!orbitals.empty() && orbitals[0] <= kMaxComponents &&
           static_cast<double>(orbitals.size()) < orbitals[0] + 1) {  // Ten to a line.
      const std::vector<double> more = finite_numbers(std::string(take_line(rest)));
      if (more.empty()) break;
      orbitals.insert(orbitals.end(), more.begin(), more.end());
    }
    if (orbitals.empty() || orbitals[0] < 1 || orbitals[0] > kMaxComponents ||
        orbitals.size() != static_cast<std::size_t>(orbitals[0]) + 1) {
      fail_reading(path, "the line of its orbitals is invalid", "Write one orbital to a file");
    }
    components = static_cast<std::int64_t>(orbitals[0]);
  }
  ImageHeader header{
      .type = StoredType::kF32,
      .values = {Basis::kByFormat, Basis::kByFormat, Basis::kByFormat},
      .meaning = {.length_unit = grid->counts[0] < 0 ? "Å" : "bohr", .value_unit = {}},
      .components = components};
  for (std::size_t axis = 0; axis < 3; ++axis) header.dims[axis] = std::abs(grid->counts[2 - axis]);
  set_axes(header, {grid->steps[2], grid->steps[1], grid->steps[0]}, stated(grid->origin));
  check_header(path, header);
  const auto begin = static_cast<std::uint64_t>(beginning.size() - rest.size());
  return {.header = header,
          .slices = text_slices({.file = path,
                                 .begin = begin,
                                 .are_all = true,
                                 .packing = is_packed ? packing : Packing::kNone},
                                header)};
}

}  // namespace multitetra

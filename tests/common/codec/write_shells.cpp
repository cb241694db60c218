// Writes sample shells of generated fields for decoders in other languages, laid out as in
// tests/golden: FOLDER/shell_NAME.bin, and FOLDER/shells.txt with what they decode to.
//
//   write_shells FOLDER X Y Z    (boxes of at most X x Y x Z cells)

#include <array>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/fields.hpp"
#include "tests/support/golden_shells.hpp"

namespace multitetra::testing {
namespace {

struct WrittenField {
  std::string name;
  Volume volume;
  double isovalue = 0;
  std::optional<double> outside = std::nullopt;
};

std::vector<WrittenField> written_fields() {
  return {{"noise", fields::noise({19, 26, 17}, 31), 0.5},
          {"noise_in_a_value", fields::noise({18, 9, 20}, 32), 0.5, 0.0},
          {"long_rows", fields::noise({66, 9, 7}, 38), 0.5},
          {"plateaus", fields::integer_noise({17, 18, 19}, 4, 33), 2},
          {"integers", fields::integer_noise({16, 20, 18}, 200, 34), 100.5, 300.0},
          {"gyroid", fields::gyroid(25, 0.3, 35), 0.1},
          {"masked", fields::masked_gyroid(25, 36), 0.1},
          {"masked_in_a_value", fields::masked_gyroid(21, 37), 0.1, -1.0},
          {"ball", fields::ball({21, 22, 23}, 8), 0}};
}

std::vector<shell::ShellOptions> written_modes(const Volume& volume, double isovalue) {
  using shell::ShellValues;
  std::vector<shell::ShellOptions> modes;
  if (volume.type() != SampleType::kF32) modes.push_back({.isovalue = isovalue});
  for (const int resolution : {1, 5, 8}) {
    modes.push_back({.isovalue = isovalue,
                     .values = ShellValues::kLatticeExact,
                     .lattice_resolution = resolution});
  }
  for (const int levels : {1, 2, 4, 8}) {
    modes.push_back({.isovalue = isovalue,
                     .values = ShellValues::kQuantized,
                     .levels_per_octave = levels,
                     .lattice_resolution = levels});
  }
  return modes;
}

void write(const std::filesystem::path& folder, const std::string& name, const OwnedBox& box,
           const shell::ShellOptions& options, std::ostream& listing) {
  const auto bytes = shell::encode_shell(box.box(), options);
  if (!bytes) throw std::runtime_error(name + ": " + bytes.error().text);
  const DecodedShell decoded = decode_shell(*bytes);
  if (decoded.status != shell::ShellStatus::kOk || decoded.mesh.triangles.empty()) {
    throw std::runtime_error(name + " does not decode to a surface");
  }
  std::ofstream file(folder / ("shell_" + name + ".bin"), std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes->data()),
             static_cast<std::streamsize>(bytes->size()));
  listing << name << ' ' << std::dec << decoded.mesh.vertices.size() << ' '
          << decoded.mesh.triangles.size() << ' ' << std::hex << checksum(decoded.mesh) << '\n';
}

void write_all(const std::filesystem::path& folder, const std::array<std::int32_t, 3>& cells) {
  std::filesystem::create_directories(folder);
  std::ofstream listing(folder / "shells.txt");
  for (const WrittenField& field : written_fields()) {
    const std::int32_t margin = field.outside ? 1 : 0;
    const OwnedBox box = box_in(field.volume, field.outside, margin, 1, {0, 0, 0}, cells).value();
    int number = 0;
    for (const shell::ShellOptions& options : written_modes(field.volume, field.isovalue)) {
      write(folder, field.name + "_" + std::to_string(++number), box, options, listing);
    }
  }
}

}  // namespace
}  // namespace multitetra::testing

int main(int count, char** arguments) {
  if (count != 5) return 2;
  try {
    multitetra::testing::write_all(
        arguments[1], {std::stoi(arguments[2]), std::stoi(arguments[3]), std::stoi(arguments[4])});
    return 0;
  } catch (const std::exception& trouble) {
    std::cerr << "write_shells: " << trouble.what() << "\n";
    return 1;
  }
}

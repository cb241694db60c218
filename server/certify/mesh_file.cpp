#include "server/certify/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "common/base/open_file.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/mesh/lattice.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/mesh_readers.hpp"
#include "server/certify/detail/vtp_reader.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string contents_of(const fs::path& file) {
  const OpenFile opened(file);
  if (!opened.regular_size()) fail_reading(file, "the file does not exist", "Check its name");
  auto bytes = opened.content(SIZE_MAX);
  if (!bytes) fail_reading(file, "it cannot be read", "Check the disk");
  return *std::move(bytes);
}

// Returns the text after the title of our files in the same line: ", lattice 5, min_component 12".
std::string_view facts_in(std::string_view file) {
  constexpr std::size_t kWithin = 256;
  const std::string_view header = file.substr(0, kWithin);
  const std::size_t title = header.find(kMeshFileTitle);
  if (title == std::string_view::npos) return {};
  const std::string_view facts = header.substr(title + kMeshFileTitle.size());
  return facts.substr(0, facts.find('\n'));
}

template <typename Number>
std::optional<Number> fact(std::string_view facts, std::string_view name) {
  const std::string before = ", " + std::string(name) + " ";
  const std::size_t found = facts.find(before);
  if (found == std::string_view::npos) return std::nullopt;
  const std::string_view rest = facts.substr(found + before.size());
  return parse_number<Number>(rest.substr(0, rest.find_first_not_of("0123456789.e+-")));
}

TriangleMesh with_facts(TriangleMesh mesh, std::string_view file) {
  const std::string_view facts = facts_in(file);
  const auto lattice = fact<int>(facts, "lattice");
  if (lattice && *lattice >= kMinLatticeResolution && *lattice <= kMaxLatticeResolution) {
    mesh.lattice = lattice;
  }
  const auto diagonal = fact<double>(facts, "min_component");
  if (diagonal && *diagonal > 0 && std::isfinite(*diagonal)) mesh.min_component = *diagonal;
  return mesh;
}

// Returns the format that the content shows, or nullopt.
std::optional<MeshFormat> format_by_content(std::string_view bytes) {
  constexpr std::size_t kWithin = 4096;
  if (bytes.starts_with("glTF")) return MeshFormat::kGlb;
  if (bytes.starts_with("DRACO")) return MeshFormat::kDrc;
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return MeshFormat::kPly;
  constexpr std::size_t kStlHeader = 84;
  if (bytes.size() >= kStlHeader) {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, bytes.data() + kStlHeader - 4, sizeof triangles);
    if (bytes.size() == kStlHeader + std::size_t{50} * triangles) return MeshFormat::kStl;
  }
  std::string_view text = bytes.substr(0, kWithin);
  if (text.find("<VTKFile") != text.npos) return MeshFormat::kVtp;
  while (!text.empty()) {
    std::string_view line = take_line(text);
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == line.npos || line[begin] == '#') continue;
    line.remove_prefix(begin);
    const std::string word = lower_case(line.substr(0, line.find_first_of(" \t\r")));
    if (word == "solid") return MeshFormat::kStl;
    constexpr std::array<std::string_view, 10> kObjWords = {"v", "vn",     "vt",     "f", "o",
                                                            "g", "mtllib", "usemtl", "s", "l"};
    const bool is_obj = std::find(kObjWords.begin(), kObjWords.end(), word) != kObjWords.end();
    return is_obj ? std::optional(MeshFormat::kObj) : std::nullopt;
  }
  return std::nullopt;
}

TriangleMesh read(const fs::path& file) {
  const std::optional<MeshFormat> by_suffix = mesh_format_from(file.extension().string());
  if (by_suffix == MeshFormat::kVtp) return read_vtp(file);
  const std::string bytes = contents_of(file);
  const std::optional<MeshFormat> by_content = format_by_content(bytes);
  const bool has_no_signature = by_suffix == MeshFormat::kStl || by_suffix == MeshFormat::kObj;
  const std::optional<MeshFormat> format = by_content || !has_no_signature ? by_content : by_suffix;
  if (!format) {
    throw MeshFileError(
        "its format is unknown: it begins with neither 'ply', 'glTF', 'DRACO' nor 'solid', has no "
        "'<VTKFile', no lines of OBJ and not the length of binary STL, and its name ends in "
        "neither .stl nor .obj");
  }
  switch (*format) {
    case MeshFormat::kPly:
      return with_facts(read_ply(bytes), bytes);
    case MeshFormat::kStl:
      return with_facts(read_stl(bytes), bytes);
    case MeshFormat::kObj:
      return with_facts(read_obj(bytes), bytes);
    case MeshFormat::kGlb:
      return read_glb(bytes);
    case MeshFormat::kDrc:
      return read_draco(bytes);
    case MeshFormat::kVtp:
      return read_vtp(file);
  }
  return {};
}

}  // namespace

TriangleMesh read_mesh(const fs::path& file) {
  try {
    TriangleMesh mesh = read(file);
    mesh.has_floats = true;
    for (const Vec3& vertex : mesh.vertices) {
      // Larger coordinates make squared lengths overflow or meaningless.
      constexpr double kMaxVertexCoordinate = 1e100;
      for (const double coordinate : vertex) {
        if (!(std::abs(coordinate) < kMaxVertexCoordinate))
          throw MeshFileError("a coordinate is not a number");
        mesh.has_floats = mesh.has_floats && double{static_cast<float>(coordinate)} == coordinate;
      }
    }
    return mesh;
  } catch (const MeshFileError& fault) {
    fail_reading(file, fault.what(), "Get a complete copy of the file, or save it as PLY");
  }
}

}  // namespace multitetra

#include "common/wire/mesh_files.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/atomic_file.hpp"
#include "common/base/number_text.hpp"
#include "common/base/text.hpp"
#include "common/wire/detail/file_positions.hpp"
#include "common/wire/detail/three_mf_file.hpp"
#include "common/wire/detail/triangle_normals.hpp"
#include "common/wire/detail/vtp_file.hpp"
#include "common/wire/scene_file.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PLY and STL files are written as the bytes lie in memory: little-endian.");

// In the order of MeshFormat.
struct FormatRow {
  std::string_view suffix;
  std::string_view media_type;
  bool holds_several = false;
  bool holds_colors = false;
  bool holds_normals = true;  // Of vertices.
};
constexpr std::array<FormatRow, 7> kFormats = {{
    {.suffix = "ply", .media_type = "application/ply", .holds_colors = true},
    {.suffix = "stl", .media_type = "model/stl", .holds_normals = false},
    {.suffix = "obj", .media_type = "model/obj"},
    {.suffix = "glb",
     .media_type = "model/gltf-binary",
     .holds_several = true,
     .holds_colors = true},
    {.suffix = "drc", .media_type = "application/vnd.draco"},
    {.suffix = "vtp", .media_type = "application/vnd.vtk.polydata+xml", .holds_colors = true},
    {.suffix = "3mf", .media_type = "model/3mf", .holds_several = true, .holds_normals = false},
}};

// A millionth of the longest side.
constexpr int kDracoFileBits = 20;
constexpr int kMaxDracoFileBits = 30;

template <typename T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

// ---- the formats

template <typename Positions>
std::string ply(const PositionedMesh& mesh, const Positions& positions, const char* type,
                const std::string& title, const std::string& name) {
  std::string file = "ply\nformat binary_little_endian 1.0\ncomment " + title + "\n";
  if (!name.empty()) file += "comment name " + name + "\n";
  file += "element vertex " + std::to_string(positions.size()) + "\n";
  for (const char axis : {'x', 'y', 'z'}) {
    file += std::string("property ") + type + ' ' + axis + '\n';
  }
  if (!mesh.normals.empty()) file += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.scalars.empty()) file += "property float scalar\n";
  if (!mesh.colors.empty()) {
    file += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  file += "element face " + std::to_string(mesh.triangles.size()) +
          "\nproperty list uchar uint vertex_indices\nend_header\n";
  file.reserve(file.size() + sizeof(positions[0]) * positions.size() + 12 * mesh.normals.size() +
               4 * mesh.scalars.size() + 3 * mesh.colors.size() + 13 * mesh.triangles.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    append(file, positions[i]);
    if (!mesh.normals.empty()) append(file, mesh.normals[i]);
    if (!mesh.scalars.empty()) append(file, mesh.scalars[i]);
    if (!mesh.colors.empty()) append(file, mesh.colors[i]);
  }
  for (const TriangleIndices& t : mesh.triangles) {
    file.push_back(3);
    append(file, t);
  }
  return file;
}

// An 80-byte header that must not begin with "solid", the number of triangles, then 50 bytes per
// triangle: normal, three corners, two unused bytes.
std::string stl(const PositionedMesh& mesh, const std::string& title) {
  require_floats(mesh, "STL");
  const std::vector<std::array<float, 3>> floats = float_positions(mesh);
  std::string file = title;
  file.resize(80, ' ');
  file.reserve(84 + 50 * mesh.triangles.size());
  append(file, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const TriangleIndices& t : mesh.triangles) {
    append(file, unit_or_upwards(area_vector(mesh.positions[t[0]], mesh.positions[t[1]],
                                             mesh.positions[t[2]])));
    for (const std::uint32_t corner : t) append(file, floats[corner]);
    append(file, std::uint16_t{0});
  }
  return file;
}

// Appends the shortest decimal that parses to the same number.
template <typename Number>
void append_text(std::string& file, Number number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  file.append(text.data(), static_cast<std::size_t>(end - text.data()));
}

// Appends a line for each vector: its name and three numbers.
template <typename Number>
void append_lines(std::string& file, std::string_view name,
                  const std::vector<std::array<Number, 3>>& vectors) {
  for (const std::array<Number, 3>& vector : vectors) {
    file += name;
    for (const Number coordinate : vector) {
      file += ' ';
      append_text(file, coordinate);
    }
    file += '\n';
  }
}

std::string obj(const PositionedMesh& mesh, const std::string& title, const std::string& name) {
  std::string file = "# " + title + "\n";
  // A backslash at the end of a line continues it.
  const std::size_t name_length = name.find_last_not_of("\\ ") + 1;
  if (name_length > 0) file += "o " + name.substr(0, name_length) + "\n";
  file.reserve(file.size() + 40 * (mesh.positions.size() + mesh.normals.size()) +
               (mesh.normals.empty() ? 30 : 60) * mesh.triangles.size());
  if (fits_in_floats(mesh)) {
    append_lines(file, "v", float_positions(mesh));
  } else {
    append_lines(file, "v", mesh.positions);
  }
  append_lines(file, "vn", mesh.normals);
  for (const TriangleIndices& t : mesh.triangles) {
    file += 'f';
    for (const std::uint32_t corner : t) {
      file += ' ';
      append_text(file, std::uint64_t{corner} + 1);  // OBJ indices start at 1.
      if (mesh.normals.empty()) continue;
      file += "//";
      append_text(file, std::uint64_t{corner} + 1);
    }
    file += '\n';
  }
  return file;
}

// Draco rounds to the nearest step of the longest side's range, and to floats twice.
std::string drc(const PositionedMesh& mesh) {
  if (mesh.triangles.empty()) return {};
  require_floats(mesh, "Draco");
  const auto [low, high] = position_bounds(mesh.positions);
  double range = 0;
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range = std::max(range, high[axis] - low[axis]);
    largest = std::max({largest, std::abs(low[axis]), std::abs(high[axis])});
  }
  const double limit = *std::min_element(mesh.rounding_limits.begin(), mesh.rounding_limits.end());
  int bits = kDracoFileBits;
  const auto rounding = [&] { return std::ldexp(range, -bits - 1) + std::ldexp(largest, -23); };
  while (bits < kMaxDracoFileBits && rounding() > limit) ++bits;
  if (rounding() > limit) refuse_coordinates(mesh, "Draco", rounding());
  return encode_draco_file(mesh, bits);
}

}  // namespace

std::optional<MeshFormat> mesh_format_from(std::string_view suffix) {
  if (suffix.starts_with('.')) suffix.remove_prefix(1);
  const std::string lower = lower_case(suffix);
  for (std::size_t format = 0; format < kFormats.size(); ++format) {
    if (lower == kFormats[format].suffix) return static_cast<MeshFormat>(format);
  }
  return std::nullopt;
}

std::string_view media_type(MeshFormat format) {
  return kFormats[static_cast<std::size_t>(format)].media_type;
}

bool holds_several(MeshFormat format) {
  return kFormats[static_cast<std::size_t>(format)].holds_several;
}

std::vector<std::string> left_out_notices(const PositionedMesh& mesh, MeshFormat format) {
  const FormatRow& row = kFormats[static_cast<std::size_t>(format)];
  const std::string files = "." + std::string(row.suffix) + " files have no ";
  std::vector<std::string> notices;
  if (!mesh.scalars.empty() && !row.holds_colors) {
    notices.push_back(files +
                      "values and colors of vertices; .ply, .glb and .vtp files have them.");
  }
  if (!mesh.normals.empty() && !row.holds_normals) {
    notices.push_back(files + "normals of vertices; all others but .stl and .3mf have them.");
  }
  return notices;
}

std::string mesh_file(const PositionedMesh& mesh, MeshFormat format, const MeshFileFacts& facts) {
  std::string title(kMeshFileTitle);
  if (facts.lattice) title += ", lattice " + std::to_string(*facts.lattice);
  if (facts.min_component > 0) title += ", min_component " + shortest_text(facts.min_component);
  if (facts.name.label) title += ", label " + shortest_text(*facts.name.label);
  switch (format) {
    case MeshFormat::kPly:
      return fits_in_floats(mesh)
                 ? ply(mesh, float_positions(mesh), "float", title, facts.name.text)
                 : ply(mesh, mesh.positions, "double", title, facts.name.text);
    case MeshFormat::kStl:
      return stl(mesh, title);
    case MeshFormat::kObj:
      return obj(mesh, title, facts.name.text);
    case MeshFormat::kGlb:
      return scene_glb(std::array{ScenePart{.name = facts.name, .mesh = &mesh}}, facts.world,
                       facts.codec);
    case MeshFormat::kVtp:
      return vtp_file(mesh);
    case MeshFormat::k3mf:
      return three_mf_file(std::array{ScenePart{.name = facts.name, .mesh = &mesh}}, facts.world,
                           title);
    case MeshFormat::kDrc:
      return drc(mesh);
  }
  return {};
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write_at(0, std::as_bytes(std::span(bytes)));
  file.commit(Durability::kProcessEnd);
}

}  // namespace multitetra

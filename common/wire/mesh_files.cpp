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

#include <nlohmann/json.hpp>

#include "common/base/atomic_file.hpp"
#include "common/base/text.hpp"
#include "common/wire/glb.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PLY, STL and GLB files are written as the bytes lie in memory: little-endian.");

using Position = std::array<float, 3>;

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kSuffixAndMediaType = {{
    {"ply", "application/ply"},
    {"stl", "model/stl"},
    {"obj", "model/obj"},
    {"glb", "model/gltf-binary"},
    {"drc", "application/vnd.draco"},
}};

// A millionth of the longest side: finer than any lattice step that we send.
constexpr int kDracoFileBits = 20;

template <typename T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename T>
void append_all(std::string& bytes, const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) == 12);
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

// Twice the area times the normal by the right-hand rule.
Vec3 area_vector(const Position& a, const Position& b, const Position& c) {
  const auto edge = [&a](const Position& to, std::size_t axis) {
    return static_cast<double>(to[axis]) - static_cast<double>(a[axis]);
  };
  const Vec3 u = {edge(b, 0), edge(b, 1), edge(b, 2)};
  const Vec3 v = {edge(c, 0), edge(c, 1), edge(c, 2)};
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

// Of length 1; the z axis where there is no direction.
Position unit(const Vec3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  if (!(length > 0)) return {0, 0, 1};
  return {static_cast<float>(v[0] / length), static_cast<float>(v[1] / length),
          static_cast<float>(v[2] / length)};
}

// ---- the formats

std::string ply(const PositionedMesh& mesh) {
  std::string file = "ply\nformat binary_little_endian 1.0\ncomment Multi-Tetra isosurface\n";
  file += "element vertex " + std::to_string(mesh.positions.size()) +
          "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.normals.empty()) file += "property float nx\nproperty float ny\nproperty float nz\n";
  file += "element face " + std::to_string(mesh.triangles.size()) +
          "\nproperty list uchar uint vertex_indices\nend_header\n";
  file.reserve(file.size() + 12 * (mesh.positions.size() + mesh.normals.size()) +
               13 * mesh.triangles.size());
  if (mesh.normals.empty()) append_all(file, mesh.positions);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    append(file, mesh.positions[i]);
    append(file, mesh.normals[i]);
  }
  for (const TriangleIndices& t : mesh.triangles) {
    file.push_back(3);
    append(file, t);
  }
  return file;
}

// An 80-byte header that must not begin with "solid", the number of triangles, then 50 bytes each:
// normal, three corners, two unused bytes.
std::string stl(const PositionedMesh& mesh) {
  std::string file = "Multi-Tetra isosurface, binary STL";
  file.resize(80, ' ');
  file.reserve(84 + 50 * mesh.triangles.size());
  append(file, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const TriangleIndices& t : mesh.triangles) {
    const Position& a = mesh.positions[t[0]];
    const Position& b = mesh.positions[t[1]];
    const Position& c = mesh.positions[t[2]];
    append(file, unit(area_vector(a, b, c)));
    for (const Position* corner : {&a, &b, &c}) append(file, *corner);
    append(file, std::uint16_t{0});
  }
  return file;
}

// The shortest decimal that reads back as the same number.
template <typename Number>
void append_text(std::string& file, Number number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  file.append(text.data(), static_cast<std::size_t>(end - text.data()));
}

// A line for each: its name and three numbers.
void append_lines(std::string& file, std::string_view name, const std::vector<Position>& vectors) {
  for (const Position& vector : vectors) {
    file += name;
    for (const float coordinate : vector) {
      file += ' ';
      append_text(file, coordinate);
    }
    file += '\n';
  }
}

std::string obj(const PositionedMesh& mesh) {
  std::string file = "# Multi-Tetra isosurface\n";
  file.reserve(file.size() + 40 * (mesh.positions.size() + mesh.normals.size()) +
               (mesh.normals.empty() ? 30 : 60) * mesh.triangles.size());
  append_lines(file, "v", mesh.positions);
  append_lines(file, "vn", mesh.normals);
  for (const TriangleIndices& t : mesh.triangles) {
    file += 'f';
    for (const std::uint32_t corner : t) {
      file += ' ';
      append_text(file, std::uint64_t{corner} + 1);  // OBJ counts from 1.
      if (mesh.normals.empty()) continue;
      file += "//";
      append_text(file, std::uint64_t{corner} + 1);
    }
    file += '\n';
  }
  return file;
}

// Normals at the vertices, weighted by the areas of the triangles around them.
std::vector<Position> smooth_normals(const PositionedMesh& mesh) {
  std::vector<Vec3> sums(mesh.positions.size(), Vec3{0, 0, 0});
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 area = area_vector(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    for (const std::uint32_t corner : t) {
      for (std::size_t axis = 0; axis < 3; ++axis) sums[corner][axis] += area[axis];
    }
  }
  std::vector<Position> normals(sums.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), unit);
  return normals;
}

std::pair<Position, Position> bounds(const std::vector<Position>& positions) {
  std::pair<Position, Position> box(positions.front(), positions.front());
  for (const Position& position : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.first[axis] = std::min(box.first[axis], position[axis]);
      box.second[axis] = std::max(box.second[axis], position[axis]);
    }
  }
  return box;
}

// The numbers are glTF's: 5125 unsigned int, 5126 float, 34962 and 34963 vertex and index buffers.
nlohmann::json gltf(const PositionedMesh& mesh) {
  nlohmann::json json = empty_gltf();
  if (mesh.triangles.empty()) return json;
  const auto view = [](std::size_t offset, std::size_t bytes, int target) {
    return nlohmann::json{
        {"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", target}};
  };
  const auto accessor = [](int buffer_view, int component, std::size_t count, const char* type) {
    return nlohmann::json{{"bufferView", buffer_view},
                          {"componentType", component},
                          {"count", count},
                          {"type", type}};
  };
  const std::size_t vertex_bytes = 12 * mesh.positions.size();
  const std::size_t index_bytes = 12 * mesh.triangles.size();
  const auto [low, high] = bounds(mesh.positions);

  json["buffers"] = {{{"byteLength", 2 * vertex_bytes + index_bytes}}};
  json["bufferViews"] = {view(0, vertex_bytes, 34962), view(vertex_bytes, vertex_bytes, 34962),
                         view(2 * vertex_bytes, index_bytes, 34963)};
  json["accessors"] = {accessor(0, 5126, mesh.positions.size(), "VEC3"),
                       accessor(1, 5126, mesh.positions.size(), "VEC3"),
                       accessor(2, 5125, 3 * mesh.triangles.size(), "SCALAR")};
  json["accessors"][0]["min"] = low;
  json["accessors"][0]["max"] = high;
  json["materials"] = {surface_material()};
  json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}, {"material", 0}}}}}};
  // Column-major: (x, y, z) -> (x, z, -y), z up to y up.
  json["nodes"] = {{{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}}}};
  json["scenes"][0]["nodes"] = {0};
  return json;
}

// The binary chunk has positions, normals, indices.
std::string glb(const PositionedMesh& mesh) {
  if (mesh.triangles.empty()) return glb_beginning(gltf(mesh), 0);
  std::string file =
      glb_beginning(gltf(mesh), 24 * mesh.positions.size() + 12 * mesh.triangles.size());
  append_all(file, mesh.positions);
  append_all(file, mesh.normals.empty() ? smooth_normals(mesh) : mesh.normals);
  append_all(file, mesh.triangles);
  return file;
}

}  // namespace

std::optional<MeshFormat> mesh_format_from(std::string_view suffix) {
  if (suffix.starts_with('.')) suffix.remove_prefix(1);
  const std::string lower = lower_case(suffix);
  for (std::size_t format = 0; format < kSuffixAndMediaType.size(); ++format) {
    if (lower == kSuffixAndMediaType[format].first) return static_cast<MeshFormat>(format);
  }
  return std::nullopt;
}

std::string_view media_type(MeshFormat format) {
  return kSuffixAndMediaType[static_cast<std::size_t>(format)].second;
}

std::string mesh_file(const PositionedMesh& mesh, MeshFormat format) {
  switch (format) {
    case MeshFormat::kPly:
      return ply(mesh);
    case MeshFormat::kStl:
      return stl(mesh);
    case MeshFormat::kObj:
      return obj(mesh);
    case MeshFormat::kGlb:
      return glb(mesh);
    case MeshFormat::kDrc:
      return mesh.triangles.empty() ? std::string() : encode_draco_file(mesh, kDracoFileBits);
  }
  return {};
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write_at(0, std::as_bytes(std::span(bytes)));
  file.commit(Durability::kProcessEnd);
}

}  // namespace multitetra

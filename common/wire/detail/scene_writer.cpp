#include "common/wire/detail/scene_writer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/image/srgb.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/wire/detail/file_positions.hpp"
#include "common/wire/detail/glb.hpp"
#include "common/wire/detail/meshopt_arrays.hpp"
#include "common/wire/detail/triangle_normals.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "GLB files are written as the bytes lie in memory: little-endian.");

using Json = nlohmann::json;
using Triple = std::array<float, 3>;

constexpr const char* kMeshopt = "EXT_meshopt_compression";

// glTF's constants for component types and buffer view targets.
constexpr int kByte = 5120;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr int kVertexBuffer = 34962;
constexpr int kIndexBuffer = 34963;

// Returns the lengths of the edges opposite to the corners.
Vec3 edge_lengths(const PositionedMesh& mesh, const TriangleIndices& t) {
  const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
  return {length(difference(b, c)), length(difference(c, a)), length(difference(a, b))};
}

double mean_edge_length(const PositionedMesh& mesh) {
  Vec3 total = {0, 0, 0};
  for (const TriangleIndices& t : mesh.triangles) total = sum(total, edge_lengths(mesh, t));
  const auto edges = static_cast<double>(3 * mesh.triangles.size());
  return edges > 0 ? (total[0] + total[1] + total[2]) / edges : 0;
}

// Returns vertex normals. A triangle has the weight of the sine of its corner, so that large
// triangles of a simplified mesh do not dominate. Edges count as at least half of their mean
// length: small triangles, whose normals are those of rounded vertices, have less weight.
std::vector<Triple> smooth_normals(const PositionedMesh& mesh) {
  const double shortest = std::max(mean_edge_length(mesh) / 2, 1e-100);  // Never 0.
  std::vector<Vec3> sums(mesh.positions.size(), Vec3{0, 0, 0});
  for (const TriangleIndices& t : mesh.triangles) {
    Vec3 edges = edge_lengths(mesh, t);
    for (double& edge : edges) edge = std::max(edge, shortest);
    const Vec3 area = area_vector(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    for (std::size_t i = 0; i < 3; ++i) {
      const double weight = 1 / (edges[(i + 1) % 3] * edges[(i + 2) % 3]);
      sums[t[i]] = sum(sums[t[i]], scaled(area, weight));
    }
  }
  std::vector<Triple> normals(sums.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), unit_or_upwards);
  return normals;
}

Json named(const ScenePart& part, Json what) {
  if (!part.name.text.empty()) what["name"] = part.name.text;
  return what;
}

// Vertex colors are multiplied with the base color, which is then white.
Json material_of(const ScenePart& part, std::size_t color) {
  if (!part.mesh->colors.empty()) return surface_material({1, 1, 1});
  return surface_material(color_of(part.name, color));
}

bool has_scalars(const PositionedMesh& mesh) {
  return !mesh.scalars.empty() && std::none_of(mesh.scalars.begin(), mesh.scalars.end(),
                                               [](float v) { return std::isnan(v); });
}

// Returns a node's matrix, column-major: (x, y, z) -> (x, z, -y), z up to y up, after scaling by
// `step` and moving by `origin`.
Json upright(const UnitLengths& unit, const Vec3& origin, double step = 1) {
  const auto [x, y, z] = unit;
  return {x * step, 0, 0, 0, 0, 0, -y * step, 0, 0, z * step, 0, 0, x * origin[0], z * origin[2],
          // Avoids -0.
          origin[1] == 0 ? 0 : -y * origin[1], 1};
}

template <typename T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

}  // namespace

bool is_closed(const PositionedMesh& mesh) {
  const MeshTopology found = topology(mesh.positions.size(), mesh.triangles,
                                      [](std::uint32_t, std::uint32_t) { return true; });
  return found.is_sound() && found.border_edges == 0;
}

void SceneWriter::add(const ScenePart& part, std::size_t color, const UnitLengths& unit,
                      bool has_exact_positions) {
  if (part.mesh->triangles.empty()) return;
  const bool is_packed = codec_ == MeshCodec::kMeshopt;
  const PositionedMesh ordered = is_packed ? in_compressible_order(*part.mesh) : PositionedMesh();
  const PositionedMesh& mesh = is_packed ? ordered : *part.mesh;
  const std::optional<PositionSteps> rounded =
      is_packed && !has_exact_positions ? position_steps(mesh) : std::nullopt;
  const Vec3 origin = rounded ? rounded->low : origin_for_floats(mesh);
  Json attributes;
  attributes["POSITION"] = rounded ? add_positions(*rounded) : add_positions(mesh, origin);
  attributes["NORMAL"] = add_normals(mesh);
  if (!mesh.colors.empty()) attributes["COLOR_0"] = add_colors(mesh);
  if (has_scalars(mesh)) {
    attributes["_SCALAR"] = add_attribute({.bytes = bytes_of(mesh.scalars),
                                           .component = kFloat,
                                           .type = "SCALAR",
                                           .stride = sizeof(float)});
  }
  const std::size_t indices = add_triangles(mesh);
  add_node(part, color, attributes, indices, upright(unit, origin, rounded ? rounded->step : 1));
  if (is_closed(mesh)) mark_manifold(attributes["POSITION"], indices);
}

void SceneWriter::set_world(const PhysicalMeaning& world) {
  Json& asset = json_["asset"];
  if (!world.length_unit.empty()) asset["extras"]["length_unit"] = world.length_unit;
  if (world.space != WorldSpace::kUnnamed) asset["extras"]["space"] = name(world.space);
}

void SceneWriter::make_levels(std::span<const LevelOfDetail> levels) {
  Json coarser = Json::array();
  Json coverage = Json::array();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (i > 0) coarser.push_back(i);
    coverage.push_back(levels[i].screen_coverage);
    json_["nodes"][i]["extras"]["error"] = levels[i].error;
  }
  json_["scenes"][0]["nodes"] = {0};
  if (coarser.empty()) return;
  json_["extensionsUsed"].push_back("MSFT_lod");
  json_["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = std::move(coarser);
  json_["nodes"][0]["extras"]["MSFT_screencoverage"] = std::move(coverage);
}

std::string SceneWriter::file() && {
  if (!binary_.empty()) json_["buffers"] = {{{"byteLength", binary_.size()}}};
  if (unpacked_bytes_ > 0) {
    // Stands for the unpacked arrays; the file does not have them.
    json_["buffers"].push_back(
        {{"byteLength", unpacked_bytes_}, {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
    for (const char* extension : {kMeshopt, "KHR_mesh_quantization"}) {
      json_["extensionsUsed"].push_back(extension);
      json_["extensionsRequired"].push_back(extension);
    }
  }
  return glb_beginning(json_, binary_.size()) + binary_;
}

std::size_t SceneWriter::add_positions(const PositionedMesh& mesh, const Vec3& origin) {
  require_floats(mesh, "GLB", origin);
  const std::vector<Triple> positions = float_positions(mesh, origin);
  const std::size_t accessor =
      add_attribute({.bytes = bytes_of(positions), .component = kFloat, .stride = sizeof(Triple)});
  // Rounding keeps the order of numbers.
  const auto [low, high] = position_bounds(mesh.positions);
  const auto as_floats = [&](const Vec3& corner) {
    return float_positions({.positions = {corner}, .triangles = {}}, origin).front();
  };
  json_["accessors"].back()["min"] = as_floats(low);
  json_["accessors"].back()["max"] = as_floats(high);
  return accessor;
}

std::size_t SceneWriter::add_positions(const PositionSteps& rounded) {
  const auto& steps = rounded.steps;
  const std::size_t accessor = add_attribute(
      {.bytes = bytes_of(steps), .component = kUnsignedShort, .stride = sizeof(steps[0])});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax_element(
        steps.begin(), steps.end(),
        [axis](const auto& one, const auto& other) { return one[axis] < other[axis]; });
    json_["accessors"].back()["min"].push_back((*low)[axis]);
    json_["accessors"].back()["max"].push_back((*high)[axis]);
  }
  return accessor;
}

std::size_t SceneWriter::add_normals(const PositionedMesh& mesh) {
  const std::vector<Triple> normals = mesh.normals.empty() ? smooth_normals(mesh) : mesh.normals;
  if (codec_ == MeshCodec::kNone) {
    return add_attribute(
        {.bytes = bytes_of(normals), .component = kFloat, .stride = sizeof(Triple)});
  }
  const auto packed = octahedral(normals);
  return add_attribute({.bytes = bytes_of(packed),
                        .component = kByte,
                        .stride = sizeof(packed[0]),
                        .is_normalized = true,
                        .filter = "OCTAHEDRAL"});
}

std::size_t SceneWriter::add_colors(const PositionedMesh& mesh) {
  if (codec_ == MeshCodec::kNone) {
    std::vector<Triple> colors;
    colors.reserve(mesh.colors.size());
    for (const Rgb& color : mesh.colors) colors.push_back(linear_light(color));
    return add_attribute(
        {.bytes = bytes_of(colors), .component = kFloat, .stride = sizeof(Triple)});
  }
  std::vector<std::array<std::uint16_t, 4>> colors;
  colors.reserve(mesh.colors.size());
  const auto part = [](int value) {
    return static_cast<std::uint16_t>(std::lround(65535 * double{linear_light(value)}));
  };
  for (const auto& color : mesh.colors) {
    colors.push_back({part(color[0]), part(color[1]), part(color[2]), 0});
  }
  return add_attribute({.bytes = bytes_of(colors),
                        .component = kUnsignedShort,
                        .stride = sizeof(colors[0]),
                        .is_normalized = true});
}

std::size_t SceneWriter::add_attribute(const Elements& elements) {
  const std::size_t count = elements.bytes.size() / elements.stride;
  if (codec_ == MeshCodec::kNone) {
    add_view(elements.bytes, kVertexBuffer);
  } else {
    Json extension = {{"mode", "ATTRIBUTES"}};
    if (elements.filter != nullptr) extension["filter"] = elements.filter;
    add_packed_view(meshopt_attributes(elements.bytes, elements.stride), elements.stride, count,
                    std::move(extension), kVertexBuffer);
  }
  const std::size_t accessor = add_accessor(count, elements.component, elements.type);
  if (elements.is_normalized) json_["accessors"].back()["normalized"] = true;
  return accessor;
}

std::size_t SceneWriter::add_triangles(const PositionedMesh& mesh) {
  const std::size_t corners = 3 * mesh.triangles.size();
  if (codec_ == MeshCodec::kNone) {
    add_view(bytes_of(mesh.triangles), kIndexBuffer);
    return add_accessor(corners, kUnsignedInt, "SCALAR");
  }
  const bool is_short = mesh.positions.size() <= 65535;
  const std::string packed = meshopt_triangles(mesh.triangles, mesh.positions.size());
  add_packed_view(packed, is_short ? 2 : 4, corners, {{"mode", "TRIANGLES"}}, kIndexBuffer);
  return add_accessor(corners, is_short ? kUnsignedShort : kUnsignedInt, "SCALAR");
}

std::size_t SceneWriter::add_accessor(std::size_t count, int component, const char* type) {
  json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                {"componentType", component},
                                {"count", count},
                                {"type", type}});
  return json_["accessors"].size() - 1;
}

void SceneWriter::add_view(std::span<const std::byte> bytes, int target) {
  json_["bufferViews"].push_back({{"buffer", 0},
                                  {"byteOffset", binary_.size()},
                                  {"byteLength", bytes.size()},
                                  {"target", target}});
  binary_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void SceneWriter::add_packed_view(std::string_view packed, std::size_t stride, std::size_t count,
                                  Json extension, int target) {
  extension.update({{"buffer", 0},
                    {"byteOffset", binary_.size()},
                    {"byteLength", packed.size()},
                    {"byteStride", stride},
                    {"count", count}});
  Json view = {{"buffer", 1},
               {"byteOffset", unpacked_bytes_},
               {"byteLength", count * stride},
               {"target", target},
               {"extensions", {{kMeshopt, std::move(extension)}}}};
  if (target == kVertexBuffer) view["byteStride"] = stride;
  json_["bufferViews"].push_back(std::move(view));
  binary_ += packed;
  binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
  unpacked_bytes_ = (unpacked_bytes_ + count * stride + 3) / 4 * 4;
}

void SceneWriter::mark_manifold(const Json& positions, std::size_t indices) {
  constexpr const char* kManifold = "EXT_mesh_manifold";
  Json& used = json_["extensionsUsed"];
  if (std::find(used.begin(), used.end(), kManifold) == used.end()) used.push_back(kManifold);
  json_["meshes"].back()["extensions"][kManifold]["manifoldPrimitive"] = {
      {"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", 4}};
}

void SceneWriter::add_node(const ScenePart& part, std::size_t color, const Json& attributes,
                           std::size_t indices, const Json& matrix) {
  const std::size_t number = json_["nodes"].size();
  json_["materials"].push_back(named(part, material_of(part, color)));
  json_["meshes"].push_back(
      named(part, {{"primitives",
                    {{{"attributes", attributes}, {"indices", indices}, {"material", number}}}}}));
  json_["nodes"].push_back({{"mesh", number}, {"matrix", matrix}});
  name_node(json_["nodes"].back(), part.name);
  json_["scenes"][0]["nodes"].push_back(number);
}

}  // namespace multitetra

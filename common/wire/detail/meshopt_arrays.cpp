#include "common/wire/detail/meshopt_arrays.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "common/wire/detail/file_positions.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {
namespace {

constexpr int kNormalBits = 8;

const unsigned* indices_of(std::span<const TriangleIndices> triangles) {
  return triangles.front().data();
}

// Moves value i to remap[i], in an array of `count`; drops it where that is beyond the end.
template <typename T>
std::vector<T> remapped(const std::vector<T>& values, std::span<const unsigned> remap,
                        std::size_t count) {
  if (values.empty()) return {};
  std::vector<T> moved(count);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (remap[i] < count) moved[remap[i]] = values[i];
  }
  return moved;
}

// Returns 1 / 65535 of the longest side of the positions' box.
double step_of(const PositionedMesh& mesh) {
  const auto [low, high] = position_bounds(mesh.positions);
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    longest = std::max(longest, high[axis] - low[axis]);
  }
  return longest / 65535;
}

}  // namespace

PositionedMesh in_compressible_order(const PositionedMesh& mesh) {
  PositionedMesh ordered;
  ordered.triangles.resize(mesh.triangles.size());
  const std::size_t corners = 3 * mesh.triangles.size();
  unsigned* const indices = ordered.triangles.front().data();
  meshopt_optimizeVertexCache(indices, indices_of(mesh.triangles), corners, mesh.positions.size());
  std::vector<unsigned> remap(mesh.positions.size());
  const std::size_t used =
      meshopt_optimizeVertexFetchRemap(remap.data(), indices, corners, mesh.positions.size());
  meshopt_remapIndexBuffer(indices, indices, corners, remap.data());
  ordered.rounding_limits = mesh.rounding_limits;
  ordered.positions = remapped(mesh.positions, remap, used);
  ordered.normals = remapped(mesh.normals, remap, used);
  ordered.scalars = remapped(mesh.scalars, remap, used);
  ordered.colors = remapped(mesh.colors, remap, used);
  return ordered;
}

double position_rounding(const PositionedMesh& mesh) {
  return mesh.positions.empty() ? 0 : std::sqrt(3) / 2 * step_of(mesh);
}

std::optional<PositionSteps> position_steps(const PositionedMesh& mesh) {
  PositionSteps found{
      .low = position_bounds(mesh.positions).first, .step = step_of(mesh), .steps = {}};
  if (!(found.step > 0)) return std::nullopt;
  found.steps.reserve(mesh.positions.size());
  for (const Vec3& p : mesh.positions) {
    auto& steps = found.steps.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double rounded = std::nearbyint((p[axis] - found.low[axis]) / found.step);
      steps[axis] = static_cast<std::uint16_t>(std::clamp(rounded, 0.0, 65535.0));
    }
  }
  // Vertices that coincide would be welded by readers, which changes the topology.
  std::vector<std::array<std::uint16_t, 4>> sorted = found.steps;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return std::nullopt;
  return found;
}

std::vector<std::array<std::int8_t, 4>> octahedral(std::span<const UnitVector> vectors) {
  std::vector<std::array<float, 4>> padded;
  padded.reserve(vectors.size());
  for (const UnitVector& v : vectors) padded.push_back({v[0], v[1], v[2], 0});
  std::vector<std::array<std::int8_t, 4>> encoded(vectors.size());
  if (padded.empty()) return encoded;
  meshopt_encodeFilterOct(encoded.data(), encoded.size(), sizeof(encoded[0]), kNormalBits,
                          padded.front().data());
  return encoded;
}

std::string meshopt_attributes(std::span<const std::byte> elements, std::size_t stride) {
  const std::size_t count = elements.size() / stride;
  std::string bytes(meshopt_encodeVertexBufferBound(count, stride), '\0');
  bytes.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(bytes.data()),
                                          bytes.size(), elements.data(), count, stride));
  return bytes;
}

std::string meshopt_triangles(std::span<const TriangleIndices> triangles, std::size_t vertices) {
  // The version that EXT_meshopt_compression requires.
  static const bool kHasVersion = (meshopt_encodeIndexVersion(1), true);
  static_cast<void>(kHasVersion);
  const std::size_t corners = 3 * triangles.size();
  std::string bytes(meshopt_encodeIndexBufferBound(corners, vertices), '\0');
  bytes.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(bytes.data()),
                                         bytes.size(), indices_of(triangles), corners));
  return bytes;
}

}  // namespace multitetra

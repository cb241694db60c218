#include "server/tilesets/whole_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/mesh/lattice.hpp"
#include "common/wire/scene_file.hpp"
#include "server/tilesets/detail/metres.hpp"

namespace multitetra {
namespace {

constexpr double kErrorRatio = 4;
constexpr double kMinError = 0.25;  // Voxels; applies to all levels but the finest.
// The coarsest error is at most the longest side divided by this.
constexpr double kCoarsestShare = 16;
constexpr int kNormalBits = 8;  // Enables normals; float formats do not round them.
constexpr double kScreenLines = 1080;
constexpr double kScreenAspect = 16.0 / 9;

// Returns the screen coverage of a sphere around the surface at the distance where `error` is one
// pixel.
double coverage_where_pixel(double error, double diameter) {
  const double lines = diameter / (error * kScreenLines);
  return std::min(1.0, std::numbers::pi / 4 * lines * lines / kScreenAspect);
}

double diagonal(const PositionedMesh& mesh) {
  Vec3 low = mesh.positions.front();
  Vec3 high = low;
  for (const Vec3& position : mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], position[axis]);
      high[axis] = std::max(high[axis], position[axis]);
    }
  }
  return length(difference(high, low));
}

}  // namespace

std::vector<WholeLevel> whole_levels(const DatasetInfo& info, const TilesetSettings& settings) {
  const double coarsest = *std::max_element(info.dims.begin(), info.dims.end()) / kCoarsestShare;
  const int resolution = std::min(kDefaultLatticeResolution, kMaxLatticeBits - info.grid_exponent);
  const double rounding = lattice_rounding_world(info, resolution);
  std::vector<WholeLevel> levels;
  double error = settings.error;
  do {
    levels.push_back({.request = {.isovalue = settings.isovalue,
                                  .error = error,
                                  .lattice_resolution = resolution,
                                  .simplify = true,
                                  .normal_bits = kNormalBits},
                      .error_bound = error * voxel_length(info) + rounding});
    error = kErrorRatio * std::max(error, kMinError);
  } while (error <= coarsest);
  return levels;
}

std::string whole_levels_glb(std::span<const LevelMesh> levels, const DatasetInfo& info,
                             MeshCodec codec) {
  const double metres = metres_a_unit(info);
  std::vector<PositionedMesh> meshes;
  meshes.reserve(levels.size());
  for (const LevelMesh& level : levels) {
    meshes.push_back(positioned(in_canonical_order(level.mesh), grid_to_world(info)));
  }
  std::vector<LevelOfDetail> details;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const bool is_coarsest = i + 1 == levels.size();
    const double rounding = codec == MeshCodec::kNone ? 0 : position_rounding(meshes[i]);
    details.push_back({.mesh = &meshes[i],
                       .error = (levels[i].error_bound + rounding) * metres,
                       .screen_coverage = is_coarsest
                                              ? 0
                                              : coverage_where_pixel(levels[i + 1].error_bound,
                                                                     diagonal(meshes.front()))});
  }
  return levels_glb(details, metres, codec);
}

}  // namespace multitetra

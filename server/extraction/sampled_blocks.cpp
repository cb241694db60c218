#include "server/extraction/sampled_blocks.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/wire/tile.hpp"
#include "server/core/planning/surface_size.hpp"
#include "server/core/simplification/simplified_cube.hpp"
#include "server/extraction/normal_encoder.hpp"

namespace multitetra {
namespace {

constexpr SimplifiedTileLimits kNoLimits = {
    .triangles = std::numeric_limits<std::size_t>::max(),
    .vertices_before = std::numeric_limits<std::size_t>::max()};

void add(SimplifiedBlocks& all, const SimplifiedBlocks& one) {
  all.count += one.count;
  all.before += one.before;
  all.left += one.left;
  all.border_edges += one.border_edges;
}

// Processes blocks of one surface, each by itself.
class BlockSampler {
 public:
  BlockSampler(const SurfaceExtractor& extractor, const PreparedModel& model,
               const ResolvedStep& spec, const std::stop_token& stop)
      : extractor_(extractor),
        model_(model),
        spec_(spec),
        stop_(stop),
        normals_(extractor.dataset(), spec.step()),
        border_(data_border(extractor.dataset().info, request().lattice_resolution,
                            request().topology_tolerance, spec.step().finest_spacing)),
        options_({.isovalue = request().isovalue,
                  .lattice_resolution = request().lattice_resolution,
                  .max_triangles = kMaxTileTriangles}) {}

  [[nodiscard]] SampledBlocks encoded(const OctreeCube& cube) const {
    SampledBlocks block;
    if (!is_refined(model_, cube)) return block;
    TileMesh tile{cube, surface(cube)};
    const auto before = static_cast<double>(tile.mesh.triangles.size());
    if (before == 0) return block;
    if (request().simplify) {
      Simplified left = simplified(tile.mesh, spec_.simplification(), checkpoint());
      block.triangles = counted(before, left.mesh);
      tile.simplification_bound = left.bound;
      tile.mesh = std::move(left.mesh);
    } else {
      block.triangles = {.count = 1, .before = before, .left = before};
    }
    block.bytes = static_cast<double>(normals_.encoded(tile, digest(tile.mesh)).summary.bytes);
    return block;
  }

  // The whole surface in a cube: with its octants simplified separately, and joined.
  struct Octants {
    SimplifiedBlocks apart, joined;
  };
  [[nodiscard]] Octants octants(const OctreeCube& cube) const {
    Octants counts;
    std::vector<SimplifiedCube> children;
    const SimplificationOptions how = spec_.simplification();
    for (int i = 0; i < 8; ++i) {
      const OctreeCube child = cube.child(i);
      if (!is_refined(model_, child)) continue;
      SimplifiedCube left{child, {}, {surface(child), how.lattice_step}};
      const auto before = static_cast<double>(left.rest.triangles());
      if (before == 0) continue;
      left.rest.simplify(how.max_distance, checkpoint());
      add(counts.apart, counted(before, left.rest.result().mesh));
      children.push_back(std::move(left));
    }
    LatticeMesh own = join_children(model_, cube, std::vector<CubeSurface>(8), options_).rest;
    const double before = counts.apart.before + static_cast<double>(own.triangles.size());
    const SimplifiedCube joined = join_simplified(
        cube, std::move(children),
        own.triangles.empty() ? std::nullopt
                              : std::optional(SimplifiedPiece(std::move(own), how.lattice_step)),
        how, kNoLimits, checkpoint());
    counts.joined = counted(before, joined.rest.result().mesh);
    return counts;
  }

 private:
  [[nodiscard]] const IsosurfaceRequest& request() const { return spec_.request(); }
  [[nodiscard]] std::function<void()> checkpoint() const {
    return [this] { throw_if_stopped(stop_); };
  }
  [[nodiscard]] LatticeMesh surface(const OctreeCube& cube) const {
    CubeMemoryPool::Lease lease(extractor_.pool());
    return surface_in_cube(model_, cube, options_, lease.memory()).rest;
  }
  // Tiles also have a border where the data ends.
  [[nodiscard]] SimplifiedBlocks counted(double before, const LatticeMesh& left) const {
    return {.count = 1,
            .before = before,
            .left = static_cast<double>(left.triangles.size()),
            .border_edges = static_cast<double>(topology(left, border_).open_edges)};
  }

  const SurfaceExtractor& extractor_;
  const PreparedModel& model_;
  const ResolvedStep& spec_;
  const std::stop_token& stop_;
  NormalEncoder normals_;
  DataBorder border_;
  SurfaceOptions options_;
};

// Returns the distinct ancestors, `levels_up` levels up, of `count` evenly spaced cubes.
std::vector<OctreeCube> spread(std::span<const OctreeCube> cubes, std::size_t count,
                               int levels_up) {
  std::vector<OctreeCube> around;
  for (std::size_t i = 0; i < count && !cubes.empty(); ++i) {
    OctreeCube cube = cubes[(2 * i + 1) * cubes.size() / (2 * count)];
    for (int level = 0; level < levels_up; ++level) cube = cube.parent();
    around.push_back(cube);
  }
  around.erase(std::unique(around.begin(), around.end()), around.end());
  return around;
}

}  // namespace

std::optional<SampledBlocks> sampled_blocks(const SurfaceExtractor& extractor,
                                            const PreparedModel& model,
                                            std::span<const OctreeCube> cubes,
                                            const ResolvedStep& spec, const BlockCounts& counts,
                                            const std::stop_token& stop) {
  const int levels = extractor.dataset().info.grid_exponent - CubeSample::kExponent;
  if (levels < 1) return std::nullopt;
  const std::vector<OctreeCube> blocks = spread(cubes, counts.blocks, 1);
  const std::vector<OctreeCube> joined =
      spread(cubes, levels > 1 && spec.request().simplify ? counts.joined : 0, 2);
  const BlockSampler sampler(extractor, model, spec, stop);
  std::vector<SampledBlocks> found(blocks.size());
  std::vector<BlockSampler::Octants> octants(joined.size());
  in_parallel(
      joined.size() + blocks.size(),
      [&](std::size_t i) {
        if (i < joined.size()) {
          octants[i] = sampler.octants(joined[i]);
        } else {
          found[i - joined.size()] = sampler.encoded(blocks[i - joined.size()]);
        }
      },
      stop);
  SampledBlocks all;
  for (const SampledBlocks& one : found) {
    add(all.triangles, one.triangles);
    all.bytes += one.bytes;
  }
  if (all.triangles.left == 0) return std::nullopt;
  SimplifiedBlocks apart = all.triangles;
  SimplifiedBlocks together = all.triangles;
  if (!joined.empty()) {
    apart = together = {};
    for (const auto& one : octants) {
      add(apart, one.apart);
      add(together, one.joined);
    }
  }
  all.triangles_per_border_edge = estimate_triangles_per_border_edge(apart, together);
  return all;
}

}  // namespace multitetra

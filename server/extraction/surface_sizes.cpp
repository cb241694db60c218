#include "server/extraction/surface_sizes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/octree_cube.hpp"
#include "common/wire/tile.hpp"
#include "server/core/fine_errors/prepared_model.hpp"
#include "server/core/planning/simplified_size.hpp"
#include "server/core/planning/surface_size.hpp"
#include "server/core/simplification/threshold_shares.hpp"
#include "server/core/surface/tiling.hpp"
#include "server/extraction/detail/prefetch_bricks.hpp"
#include "server/extraction/detail/shell_size.hpp"
#include "server/extraction/normal_encoder.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/sampled_blocks.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

// The refined cubes of a model with similar thresholds: a few of them can represent the group, and
// no small region of small thresholds is missed.
struct CubeGroup {
  std::vector<OctreeCube> cubes;  // Cubes of CubeSample::kExponent, in octree order.
  // Rough numbers of triangles, from the spectrum and the thresholds alone: of the model's surface,
  double extracted = 0;
  double left = 0;  // and of the simplified surface.
};

// Returns the typical number of triangles of a full surface in a refined cube of 16 steps, by the
// allowed error in voxels. Public volumes have 560 to 970 at a quarter of a voxel, 380 to 740 at
// one voxel, 270 to 560 at two.
double triangles_a_cube(double voxels) { return 600 / (1 + 0.6 * voxels); }

// Returns the octave of a threshold in voxels, clamped where surfaces hardly differ.
int octave(double voxels) {
  constexpr int kLowest = -4;
  constexpr int kHighest = 3;
  return voxels > 0 ? std::clamp(std::ilogb(voxels), kLowest, kHighest) : kLowest;
}

// Groups cubes by the octave of the least threshold in their parents: at most eight groups, or one
// for a uniform threshold. Throws Cancelled soon after `stop` is triggered.
std::vector<CubeGroup> cubes_by_threshold(const PreparedModel& model, bool simplify,
                                          const std::stop_token& stop) {
  const double voxel = voxel_length(model.volume().info);
  const double share = simplify ? kModelShare : 1;
  const auto voxels_in = [&](const OctreeCube& cube) {
    return model.thresholds().least_in(box_of(cube)) / voxel;
  };
  std::map<int, CubeGroup> groups;
  visit_refined_cubes(model, CubeSample::kExponent, [&](const OctreeCube& cube) {
    throw_if_stopped(stop);
    const double voxels = voxels_in(cube);
    const double triangles = triangles_a_cube(voxels);
    CubeGroup& group = groups[octave(voxels_in(cube.parent()) / share)];
    group.cubes.push_back(cube);
    group.extracted += triangles;
    group.left += triangles * (simplify ? rough_remaining_share(voxels / share) : 1);
  });
  std::vector<CubeGroup> sorted;
  for (auto& [unused, group] : groups) sorted.push_back(std::move(group));
  return sorted;
}

constexpr std::size_t kQuickCubes = 32;
constexpr std::size_t kAccurateCubes = 256;
constexpr BlockCounts kQuickBlocks = {.blocks = 4};
// Surfaces with fewer triangles before simplification are built to measure their size: their tiles
// are small, so sampled blocks would not represent them.
constexpr double kMaxMeasuredTriangles = 80'000;
constexpr double kBytesPerBlock = 60;  // Encoded, independent of the content.
// Bytes of a simplified triangle in a tile relative to one in a block, which has more small
// triangles at its border: 0.7 to 0.9 on public volumes.
constexpr double kBytesInTiles = 0.82;
// Triangles of a preview in a refined cube of twice its finest spacing: 4 to 21 on public volumes.
constexpr double kTrianglesPerPreviewCube = 16;

// Returns fewer blocks the more there is to simplify in each.
BlockCounts accurate_blocks(double triangles_a_cube) {
  constexpr double kTrianglesToSimplify = 120'000;
  constexpr double kCubesPerBlock = 5;  // The average number of cubes with any surface in a block.
  return {.blocks = static_cast<std::size_t>(
              std::clamp(kTrianglesToSimplify / (kCubesPerBlock * triangles_a_cube), 12.0, 24.0)),
          .joined = 3};
}

SurfaceSize size_with(double triangles, double extracted, const StepRequest& step) {
  const double share_of_bytes = step.request.simplify ? kBytesOfSimplifiedTriangles : 1;
  return {.triangles = triangles,
          .bytes = share_of_bytes * estimated_bytes(triangles, step),
          .extracted = extracted};
}

// Returns the size of an extracted surface.
SurfaceSize exact_size(const TiledMesh& surface, const PreparedVolume& volume,
                       const StepRequest& step) {
  const NormalEncoder normals(volume, step);
  SurfaceSize size{.extracted =
                       kTrianglesPerTetrahedron * static_cast<double>(surface.active_tetrahedra)};
  for (const TileMesh& tile : surface.tiles) {
    const TileSummary encoded = normals.encoded(tile, digest(tile.mesh)).summary;
    size.triangles += static_cast<double>(encoded.triangles);
    size.bytes += static_cast<double>(encoded.bytes);
  }
  return size;
}

// Returns the size of a surface with this number of triangles before simplification, if its density
// is that of the sampled blocks.
SurfaceSize size_like(const SampledBlocks& blocks, double triangles, const StepRequest& step) {
  const double remaining =
      step.request.simplify
          ? remaining_share(blocks.triangles, blocks.triangles_per_border_edge, triangles)
          : 1;
  const double headers = kBytesPerBlock * static_cast<double>(blocks.triangles.count);
  const double bytes_per_triangle = (step.request.simplify ? kBytesInTiles : 1) *
                                    std::max(blocks.bytes - headers, 0.5 * blocks.bytes) /
                                    blocks.triangles.left;
  return {.triangles = remaining * triangles,
          .bytes = remaining * triangles * bytes_per_triangle +
                   kBytesPerTile * std::ceil(remaining * triangles / kTrianglesPerTile),
          .extracted = triangles};
}

// Returns the size of a preview from the spectrum alone. Requires at least its finest spacing.
SurfaceSize preview_size(const PreparedModel& model, const StepRequest& step,
                         const std::stop_token& stop) {
  const int exponent = std::countr_zero(static_cast<unsigned>(step.finest_spacing)) + 1;
  double triangles = 0;
  visit_refined_cubes(model, exponent, [&](const OctreeCube&) {
    throw_if_stopped(stop);
    triangles += kTrianglesPerPreviewCube;
  });
  return size_with(step.request.simplify ? kPreviewRemainingShare * triangles : triangles,
                   triangles, step);
}

// Estimates the size of the whole surface from the spectrum and the thresholds alone: smaller
// thresholds leave more triangles.
SurfaceSize rough_size(const PreparedModel& model, const StepRequest& step,
                       const std::stop_token& stop) {
  double extracted = 0;
  double triangles = 0;
  for (const CubeGroup& group : cubes_by_threshold(model, step.request.simplify, stop)) {
    extracted += group.extracted;
    triangles += group.left;
  }
  return size_with(triangles, extracted, step);
}

// The decoded spectrum, shared by successive requests, most of which have the same isovalue.
class SharedSpectrum {
 public:
  explicit SharedSpectrum(const PreparedVolume& volume) : volume_(volume) {}

  [[nodiscard]] PreparedModel model(const ResolvedStep& spec) {
    const IsosurfaceRequest& request = spec.request();
    if (!spectrum_ || request.isovalue != request_.isovalue ||
        request.error_measure != request_.error_measure ||
        request.topology_rule != request_.topology_rule) {
      spectrum_ = std::make_shared<const SpectrumErrors>(
          volume_, request.isovalue, request.error_measure, request.topology_rule);
      request_ = request;
    }
    return prepared_model(volume_, spec, spectrum_);
  }

 private:
  const PreparedVolume& volume_;
  IsosurfaceRequest request_;
  std::shared_ptr<const SpectrumErrors> spectrum_;
};

// Returns the size of a surface under a threshold map, from blocks of each group of thresholds.
SurfaceSize size_by_threshold(const SurfaceExtractor& extractor, const PreparedModel& model,
                              const ResolvedStep& spec, const BlockCounts& counts, double triangles,
                              const std::stop_token& stop) {
  constexpr double kMinBlocks = 2;
  const std::vector<CubeGroup> groups = cubes_by_threshold(model, spec.request().simplify, stop);
  CubeGroup all;
  for (const CubeGroup& group : groups) {
    all.extracted += group.extracted;
    all.left += group.left;
  }
  SurfaceSize size{.extracted = triangles};
  for (const CubeGroup& group : groups) {
    const double blocks = static_cast<double>(counts.blocks) * group.left / all.left;
    const auto sampled = sampled_blocks(
        extractor, model, group.cubes, spec,
        {.blocks = static_cast<std::size_t>(std::max(std::round(blocks), kMinBlocks))}, stop);
    const double before = triangles * group.extracted / all.extracted;
    const SurfaceSize part =
        sampled ? size_like(*sampled, before, spec.step())
                : size_with(before * group.left / group.extracted, before, spec.step());
    size.triangles += part.triangles;
    size.bytes += part.bytes;
  }
  return size;
}

SurfaceSize sampled_size(const SurfaceExtractor& extractor, SharedSpectrum& spectrum,
                         const StepRequest& step, SizeAccuracy accuracy,
                         const std::stop_token& stop) {
  const ResolvedStep spec = resolved_step(step, extractor.dataset().info, stop);
  const PreparedModel model = spectrum.model(spec);
  if (step.finest_spacing >= kSpectrumSpacing && accuracy == SizeAccuracy::kQuick) {
    return preview_size(model, step, stop);
  }
  const double isovalue = step.request.isovalue;
  const CubeSample sample =
      sample_cubes(model, accuracy == SizeAccuracy::kQuick ? kQuickCubes : kAccurateCubes, isovalue,
                   [&stop] { throw_if_stopped(stop); });
  std::vector<std::uint64_t> crossed(sample.cubes.size());
  in_parallel(
      crossed.size(),
      [&](std::size_t i) {
        CubeMemoryPool::Lease lease(extractor.pool());
        crossed[i] = crossed_tetrahedra(model, sample.cubes[i], isovalue, lease.memory());
      },
      stop);
  const auto found =
      static_cast<double>(std::accumulate(crossed.begin(), crossed.end(), std::uint64_t{0}));
  const double triangles = kTrianglesPerTetrahedron *
                           (static_cast<double>(sample.coarse_tetrahedra) + sample.weight * found);
  SurfaceSize size = size_with(triangles, triangles, step);
  const bool is_accurate = accuracy == SizeAccuracy::kAccurate;
  if (step.request.simplify && is_accurate && triangles <= kMaxMeasuredTriangles) {
    return exact_size(extractor.extract(spec, stop), extractor.dataset(), step);
  }
  if (step.request.simplify || (is_accurate && step.finest_spacing < kSpectrumSpacing)) {
    const BlockCounts blocks =
        is_accurate ? accurate_blocks(triangles /
                                      (sample.weight * static_cast<double>(sample.cubes.size())))
                    : kQuickBlocks;
    const bool is_mapped = model.thresholds().least() < model.thresholds().largest();
    if (is_mapped) return size_by_threshold(extractor, model, spec, blocks, triangles, stop);
    const auto sampled = sampled_blocks(extractor, model, sample.cubes, spec, blocks, stop);
    if (sampled) size = size_like(*sampled, triangles, step);
  }
  return size;
}

}  // namespace

SizeEstimates surface_sizes(const SurfaceExtractor& extractor, std::stop_token stop,
                            SizeAccuracy accuracy) {
  const PreparedVolume& dataset = extractor.dataset();
  const auto spectrum = std::make_shared<SharedSpectrum>(dataset);
  const bool has_spectrum = dataset.info.grid_exponent > kSpectrumExponent;
  const auto on_small_grid = [&dataset, stop](const StepRequest& step) {
    // A pass over it is cheap.
    return exact_size(
        ReferenceExtractor(dataset).extract(resolved_step(step, dataset.info, stop), stop), dataset,
        step);
  };
  return {.of =
              [=, &extractor, &dataset](const StepRequest& step) {
                if (step.shell) return shell_size(dataset, step);
                return has_spectrum ? sampled_size(extractor, *spectrum, step, accuracy, stop)
                                    : on_small_grid(step);
              },
          .rough =
              [=, &dataset](const IsosurfaceRequest& request) {
                const StepRequest step = {.request = request};
                if (!has_spectrum) return on_small_grid(step);
                const ResolvedStep spec = resolved_step(step, dataset.info, stop);
                return rough_size(spectrum->model(spec), step, stop);
              },
          .to_fetch =
              [&dataset](std::int32_t finest) { return spectrum_bytes_to_fetch(dataset, finest); }};
}

}  // namespace multitetra

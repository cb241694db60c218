#include "server/programs/plot/size_curves.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/sampled_blocks.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

// Used for each isovalue and error, so far fewer blocks than for a single estimate.
constexpr BlockCounts kBlocks = {.blocks = 8, .joined = 1};

// Estimates the triangles at one isovalue for every error. All errors use the sample cubes of the
// smallest error: cubes refined for a larger error are also refined for a smaller one, and all
// curves share the sampling error.
std::vector<double> sampled_triangles(const SurfaceExtractor& extractor, double isovalue,
                                      const std::vector<double>& errors,
                                      const SizeCurvesOptions& options) {
  const PreparedVolume& dataset = extractor.dataset();
  StepRequest step = {.request = {.isovalue = isovalue, .simplify = options.simplify}};
  const auto spectrum = std::make_shared<const SpectrumErrors>(
      dataset, isovalue, step.request.error_measure, step.request.topology_rule);
  const auto spec_of = [&](double error) {
    step.request.error = error;
    return ResolvedStep(step, dataset.info);
  };
  const auto model_of = [&](double error) {
    return prepared_model(dataset, spec_of(error), spectrum);
  };
  const double least = *std::min_element(errors.begin(), errors.end());
  const CubeSample sample = sample_cubes(model_of(least), options.cubes, isovalue);
  CubeMemoryPool::Lease lease(extractor.pool());
  std::vector<double> triangles;
  for (const double error : errors) {
    const PreparedModel model = model_of(error);
    std::uint64_t crossed = 0;
    for (const OctreeCube& cube : sample.cubes) {
      if (!is_refined(model, cube)) continue;
      crossed += crossed_tetrahedra(model, cube, isovalue, lease.memory());
    }
    const std::uint64_t coarse = sample_cubes(model, 0, isovalue).coarse_tetrahedra;
    triangles.push_back(kTrianglesPerTetrahedron * (static_cast<double>(coarse) +
                                                    sample.weight * static_cast<double>(crossed)));
    if (!options.simplify) continue;
    const auto blocks = sampled_blocks(extractor, model, sample.cubes, spec_of(error), kBlocks, {});
    if (!blocks) continue;
    triangles.back() *=
        remaining_share(blocks->triangles, blocks->triangles_per_border_edge, triangles.back());
  }
  return triangles;
}

// Counts exactly on a grid without a spectrum, which is small.
std::vector<double> exact_triangles(const PreparedVolume& dataset, double isovalue,
                                    const std::vector<double>& errors, bool simplify) {
  std::vector<double> triangles;
  for (const double error : errors) {
    const TiledMesh surface = ReferenceExtractor(dataset).extract(resolved_step(
        {.request = {.isovalue = isovalue, .error = error, .simplify = simplify}}, dataset.info));
    double count = 0;
    for (const TileMesh& tile : surface.tiles) {
      count += static_cast<double>(tile.mesh.triangles.size());
    }
    triangles.push_back(count);
  }
  return triangles;
}

}  // namespace

std::vector<double> even_isovalues(const DatasetInfo& info, std::size_t count) {
  if (!(info.max > info.min)) return {};
  std::vector<double> isovalues;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    double isovalue = info.min + share * (info.max - info.min);
    if (info.type != SampleType::kF32) isovalue = std::floor(isovalue) + 0.5;
    if (isovalues.empty() || isovalue > isovalues.back()) isovalues.push_back(isovalue);
  }
  return isovalues;
}

SizeCurves size_curves(const SurfaceExtractor& extractor, std::vector<double> isovalues,
                       std::vector<double> errors, const SizeCurvesOptions& options) {
  const PreparedVolume& dataset = extractor.dataset();
  const bool has_spectrum = dataset.info.grid_exponent > kSpectrumExponent;
  SizeCurves curves{
      .isovalues = std::move(isovalues), .errors = std::move(errors), .triangles = {}};
  const std::size_t count = curves.isovalues.size();
  curves.triangles.resize(curves.errors.size(), std::vector<double>(count));
  if (curves.errors.empty()) return curves;
  // Guards `done` and serializes the progress function.
  std::mutex mutex;
  std::size_t done = 0;
  in_parallel(count, [&](std::size_t i) {
    const std::vector<double> triangles =
        has_spectrum
            ? sampled_triangles(extractor, curves.isovalues[i], curves.errors, options)
            : exact_triangles(dataset, curves.isovalues[i], curves.errors, options.simplify);
    for (std::size_t j = 0; j < triangles.size(); ++j) {
      // Makes the curves monotone: after simplification, a sample of a larger error may have
      // slightly more triangles.
      double least = triangles[j];
      for (std::size_t k = 0; k < triangles.size(); ++k) {
        if (curves.errors[k] <= curves.errors[j]) least = std::min(least, triangles[k]);
      }
      curves.triangles[j][i] = least;
    }
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, count);
  });
  return curves;
}

}  // namespace multitetra

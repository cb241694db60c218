#include "server/service/surface_sizes.hpp"

#include <numeric>
#include <utility>
#include <vector>

#include "server/core/surface_size.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/service/reference_extractor.hpp"
#include "server/service/surface_extractor.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kSampledCubes = 32;
// Of a cell of 8 x 8 x 8 steps that the surface crosses, at errors of a voxel or two.
constexpr double kTrianglesAWantedCell = 100;

SurfaceSize size_with(double triangles, const StepRequest& step) {
  return {.triangles = triangles, .bytes = estimated_bytes(triangles, step)};
}

// A grid that has no spectrum: a pass over it costs nothing.
SurfaceSize exact_size(const PreparedVolume& dataset, const StepRequest& step,
                       const std::stop_token& stop) {
  const TiledSurface surface = ReferenceExtractor(dataset).extract(step, stop);
  return size_with(kTrianglesATetrahedron * static_cast<double>(surface.active_tetrahedra), step);
}

SurfaceSize sampled_size(const SurfaceExtractor& extractor, const StepRequest& step,
                         const std::stop_token& stop) {
  const PreparedVolume& dataset = extractor.dataset();
  const PreparedModel model = prepared_model(dataset, step);
  const double isovalue = step.request.isovalue;
  const CubeSample sample = sample_cubes(model, kSampledCubes, isovalue);
  std::vector<std::uint64_t> crossed(sample.cubes.size());
  in_parallel(
      crossed.size(),
      [&](std::size_t i) {
        CubeMemoryPool::Lease lease(extractor.pool());
        crossed[i] = crossed_tetrahedra(model, sample.cubes[i], isovalue, lease.memory());
      },
      stop);
  const auto found = static_cast<double>(std::accumulate(crossed.begin(), crossed.end(), std::uint64_t{0}));
  return size_with(kTrianglesATetrahedron *
                       (static_cast<double>(sample.coarse_tetrahedra) + sample.weight * found),
                   step);
}

}  // namespace

StepSizes surface_sizes(const SurfaceExtractor& extractor, std::stop_token stop) {
  const PreparedVolume& dataset = extractor.dataset();
  const bool has_spectrum = dataset.info.grid_exponent > kSpectrumExponent;
  return {.of =
              [&extractor, &dataset, stop, has_spectrum](const StepRequest& step) {
                return has_spectrum ? sampled_size(extractor, step, stop)
                                    : exact_size(dataset, step, stop);
              },
          .rough =
              [&dataset, stop, has_spectrum](const IsosurfaceRequest& request) {
                const StepRequest step = {.request = request};
                if (!has_spectrum) return exact_size(dataset, step, stop);
                const std::size_t cells = count_wanted_cells(prepared_model(dataset, step));
                return size_with(kTrianglesAWantedCell * static_cast<double>(cells), step);
              }};
}

}  // namespace multitetra

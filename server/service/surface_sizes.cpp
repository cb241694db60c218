#include "server/service/surface_sizes.hpp"

#include <numeric>
#include <utility>
#include <vector>

#include "server/core/prepared_model.hpp"
#include "server/core/surface_size.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/service/reference_extractor.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kSampledCubes = 32;
// Of a cell of 8 x 8 x 8 steps that the surface crosses, at errors of a voxel or two.
constexpr double kTrianglesAWantedCell = 100;

PreparedModel model_of(const PreparedVolume& dataset, const StepRequest& step) {
  const IsosurfaceRequest& request = step.request;
  return {dataset,
          {.isovalue = request.isovalue,
           .measure = request.measure,
           .rule = request.topology_rule,
           .topology_tolerance = request.topology_tolerance},
          model_options(step, dataset.info)};
}

SurfaceSize size_with(double triangles, const StepRequest& step) {
  return {.triangles = triangles, .bytes = estimated_bytes(triangles, step)};
}

// A grid that has no spectrum: a pass over it costs nothing.
SurfaceSize exact_size(const PreparedVolume& dataset, const StepRequest& step,
                       const std::stop_token& stop) {
  const TiledSurface surface = ReferenceExtractor(dataset).extract(step, stop);
  return size_with(kTrianglesATetrahedron * static_cast<double>(surface.active_tetrahedra), step);
}

SurfaceSize sampled_size(const PreparedVolume& dataset, const StepRequest& step,
                         const std::stop_token& stop) {
  const PreparedModel model = model_of(dataset, step);
  const double isovalue = step.request.isovalue;
  const CubeSample sample = sample_cubes(model, kSampledCubes, isovalue);
  std::vector<std::uint64_t> crossed(sample.cubes.size());
  in_parallel(
      crossed.size(),
      [&](std::size_t i) {
        FineArrays arrays;
        crossed[i] = crossed_tetrahedra(model, sample.cubes[i], isovalue, arrays);
      },
      stop);
  const auto found = static_cast<double>(std::accumulate(crossed.begin(), crossed.end(), std::uint64_t{0}));
  return size_with(kTrianglesATetrahedron *
                       (static_cast<double>(sample.coarse_tetrahedra) + sample.weight * found),
                   step);
}

}  // namespace

StepSizes surface_sizes(const PreparedVolume& dataset, std::stop_token stop) {
  const bool has_spectrum = dataset.info.grid_exponent > kSpectrumExponent;
  return {.of =
              [&dataset, stop, has_spectrum](const StepRequest& step) {
                return has_spectrum ? sampled_size(dataset, step, stop)
                                    : exact_size(dataset, step, stop);
              },
          .rough =
              [&dataset, stop, has_spectrum](const IsosurfaceRequest& request) {
                const StepRequest step = {.request = request};
                if (!has_spectrum) return exact_size(dataset, step, stop);
                const std::size_t cells = count_wanted_cells(model_of(dataset, step));
                return size_with(kTrianglesAWantedCell * static_cast<double>(cells), step);
              }};
}

}  // namespace multitetra

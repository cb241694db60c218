// How long the parts take on one thread, per sample or per triangle: a head phantom with noise, 128
// samples a side.

#include <benchmark/benchmark.h>

#include "server/core/leaves.hpp"
#include "server/dataset/generators.hpp"
#include "server/dataset/statistics.hpp"
#include "server/service/surface_extractor.hpp"

namespace multitetra {
namespace {

constexpr double kIsovalue = 500.5;

const DatasetPtr& head() {
  static const DatasetPtr dataset =
      make_dataset(generate(GeneratorKind::kHead, {.size = 128, .noise = 20}), "head");
  return dataset;
}
const Field& field() {
  static const Field field(head()->volume, std::nullopt, 0);
  return field;
}
const std::shared_ptr<const SaturatedErrors>& errors() {
  static const auto errors = std::make_shared<const SaturatedErrors>(
      field(), kIsovalue, ErrorMeasure::kCertified, TopologyRule::kExact);
  return errors;
}
CubeSurface surface(double threshold) {
  const ErrorBasedModel model(errors(), {.thresholds = ThresholdMap::everywhere(threshold)});
  return surface_in_cube(model, field(), root_cube(field().grid()), {.isovalue = kIsovalue});
}

// Items are samples.
void exact_errors(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        SaturatedErrors(field(), kIsovalue, ErrorMeasure::kCertified, TopologyRule::kExact));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(head()->volume.size()));
}
BENCHMARK(exact_errors)->Unit(benchmark::kMillisecond);

std::int64_t triangles(const CubeSurface& surface) {
  auto count = static_cast<std::int64_t>(surface.rest.size());
  for (const auto& tile : surface.tiles) count += static_cast<std::int64_t>(tile.triangles.size());
  return count;
}

// Items are triangles; the argument is the threshold in hundredths of a voxel.
void extraction(benchmark::State& state) {
  const double threshold = static_cast<double>(state.range(0)) / 100;
  (void)errors();
  std::int64_t count = 0;
  for (auto _ : state) count += triangles(surface(threshold));
  state.SetItemsProcessed(count);
}
BENCHMARK(extraction)->Arg(0)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);

void tile_encoding(benchmark::State& state) {
  const CubeSurface cut = surface(0.5);
  const LatticeMesh mesh = index_triangles(cut.tiles.front().triangles, kDefaultLatticeResolution);
  std::int64_t bytes = 0;
  for (auto _ : state) bytes += encode_tile(mesh, cut.tiles.front().cube).summary.bytes;
  const auto count = state.iterations() * static_cast<std::int64_t>(mesh.triangles.size());
  state.SetItemsProcessed(count);
  state.counters["bytes_per_triangle"] = static_cast<double>(bytes) / static_cast<double>(count);
}
BENCHMARK(tile_encoding)->Unit(benchmark::kMillisecond);

// With all checks of arrival.
void tile_decoding(benchmark::State& state) {
  const CubeSurface cut = surface(0.5);
  const LatticeMesh mesh = index_triangles(cut.tiles.front().triangles, kDefaultLatticeResolution);
  const EncodedTile tile = encode_tile(mesh, cut.tiles.front().cube);
  for (auto _ : state) {
    benchmark::DoNotOptimize(decode_tile(*tile.payload, tile.summary, kDefaultLatticeResolution));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}
BENCHMARK(tile_decoding)->Unit(benchmark::kMillisecond);

void mesh_topology(benchmark::State& state) {
  std::vector<LatticeTriangle> all;  // Of the whole surface, not of one tile.
  const CubeSurface cut = surface(0);
  for (const auto& tile : cut.tiles) {
    all.insert(all.end(), tile.triangles.begin(), tile.triangles.end());
  }
  all.insert(all.end(), cut.rest.begin(), cut.rest.end());
  const LatticeMesh mesh = index_triangles(all, kDefaultLatticeResolution);
  for (auto _ : state) benchmark::DoNotOptimize(topology(mesh, {}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}
BENCHMARK(mesh_topology)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace multitetra

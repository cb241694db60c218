// How long the parts take on one thread, per sample or per triangle: a head phantom with noise, 128
// samples a side.

#include <array>
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include "server/core/leaves.hpp"
#include "server/core/own_error.hpp"
#include "server/core/own_error_curve.hpp"
#include "server/core/tiling.hpp"
#include "server/core/vertex_normals.hpp"
#include "server/dataset/generators.hpp"
#include "server/dataset/prepare.hpp"
#include "server/service/surface_extractor.hpp"

namespace multitetra {
namespace {

constexpr double kIsovalue = 500.5;

// One thread throughout, also where the work would run on all.
const tbb::global_control kOneThread(tbb::global_control::max_allowed_parallelism, 1);

const Volume& head() {
  static const Volume volume = generate(GeneratorKind::kHead, {.size = 128, .noise = 20});
  return volume;
}
const DatasetPtr& dataset() {
  static const DatasetPtr dataset = make_dataset(head(), "head");
  return dataset;
}
const Field& field() {
  static const Field field(head(), std::nullopt, 0);
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

// Diamonds with values as noisy as the head's near its skull, with the lengths of a cube's centre
// to its corners.
class NoisyDiamonds {
 public:
  static constexpr std::size_t kCount = 1024;

  NoisyDiamonds() {
    for (std::size_t i = 0; i < 8; ++i) length_.set(i, std::sqrt(3.0));
    std::minstd_rand random(1);
    std::normal_distribution<double> value(kIsovalue, 60);
    for (DiamondValues<double>& diamond : diamonds_) {
      diamond.centre = std::round(value(random));
      diamond.corners = 8;
      diamond.vectors = Lanes<double>::kVectors;
      diamond.ring_is_open = false;
      diamond.length = &length_;
      for (auto& lanes : diamond.value.vectors) lanes = all(diamond.centre);
      for (std::size_t i = 0; i < diamond.corners; ++i) {
        diamond.value.set(i, std::round(value(random)));
      }
    }
  }
  NoisyDiamonds(const NoisyDiamonds&) = delete;
  NoisyDiamonds& operator=(const NoisyDiamonds&) = delete;

  [[nodiscard]] const std::array<DiamondValues<double>, kCount>& all_of_them() const {
    return diamonds_;
  }

 private:
  Lanes<double> length_{};
  std::array<DiamondValues<double>, kCount> diamonds_{};
};

// The own error for one isovalue. Items are dividing points.
void own_errors(benchmark::State& state) {
  const NoisyDiamonds diamonds;
  for (auto _ : state) {
    for (const auto& diamond : diamonds.all_of_them()) {
      benchmark::DoNotOptimize(own_error(diamond, kIsovalue));
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(NoisyDiamonds::kCount));
}
BENCHMARK(own_errors);

// The own errors for all isovalues of the active bins. Items are dividing points.
void own_error_curves(benchmark::State& state) {
  const NoisyDiamonds diamonds;
  const IsovalueBins& bins = dataset()->spectrum.bins;
  std::array<CurveBlock, IsovalueBins::kMaxCount / 4> blocks{};
  std::int64_t active = 0;
  for (auto _ : state) {
    for (const auto& diamond : diamonds.all_of_them()) {
      const ValueRange<double> range = range_of(diamond);
      const OwnErrorCurve<double>::Bins active_bins{
          .first = bins.first_from(static_cast<float>(range.low)),
          .last = bins.last_below(static_cast<float>(range.high))};
      OwnErrorCurve<double>(bins, diamond, active_bins, blocks.data(), 0, 1).add();
      active += active_bins.last - active_bins.first + 1;
      benchmark::DoNotOptimize(blocks.data());
      benchmark::ClobberMemory();
    }
  }
  const std::int64_t count = state.iterations() * static_cast<std::int64_t>(NoisyDiamonds::kCount);
  state.SetItemsProcessed(count);
  state.counters["bins_per_point"] = static_cast<double>(active) / static_cast<double>(count);
}
BENCHMARK(own_error_curves);

// Everything that `prepare` does but the disk: range, statistics, errors for every isovalue. Items
// are voxels.
void spectrum_building(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    const auto source = source_of(head());
    state.ResumeTiming();
    benchmark::DoNotOptimize(prepare_in_memory(*source, {.name = "head"}));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(head().size()));
}
BENCHMARK(spectrum_building)->Unit(benchmark::kMillisecond);

// What the server does for a request: errors from the spectrum, tiles that are indexed. Items are
// triangles; the argument is the error in hundredths of a voxel.
void prepared_extraction(benchmark::State& state) {
  const SurfaceExtractor extractor(dataset());
  const StepRequest step{
      .request = {.isovalue = kIsovalue, .error = static_cast<double>(state.range(0)) / 100}};
  std::int64_t count = 0;
  for (auto _ : state) {
    const TiledSurface surface = extractor.extract(step);
    for (const auto& tile : surface.tiles) {
      count += static_cast<std::int64_t>(tile.mesh.triangles.size());
    }
  }
  state.SetItemsProcessed(count);
}
BENCHMARK(prepared_extraction)->Arg(0)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);

// Items are samples.
void exact_errors(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        SaturatedErrors(field(), kIsovalue, ErrorMeasure::kCertified, TopologyRule::kExact));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(head().size()));
}
BENCHMARK(exact_errors)->Unit(benchmark::kMillisecond);

std::int64_t triangles(const CubeSurface& surface) {
  auto count = static_cast<std::int64_t>(surface.rest.size());
  for (const auto& tile : surface.tiles) count += static_cast<std::int64_t>(tile.triangles.size());
  return count;
}

// From errors that are known, the reference way. Items are triangles; the argument is the threshold
// in hundredths of a voxel.
void reference_extraction(benchmark::State& state) {
  const double threshold = static_cast<double>(state.range(0)) / 100;
  (void)errors();
  std::int64_t count = 0;
  for (auto _ : state) count += triangles(surface(threshold));
  state.SetItemsProcessed(count);
}
BENCHMARK(reference_extraction)->Arg(0)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);

// Items are vertices; the argument is the source.
void normals_at_vertices(benchmark::State& state) {
  const CubeSurface cut = surface(0.5);
  const LatticeMesh mesh = index_triangles(cut.tiles.front().triangles, kDefaultLatticeResolution);
  for (auto _ : state) {
    benchmark::DoNotOptimize(vertex_normals(*dataset(), mesh.vertices, mesh.resolution,
                                            static_cast<NormalSource>(state.range(0))));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.vertices.size()));
}
BENCHMARK(normals_at_vertices)
    ->Arg(static_cast<int>(NormalSource::kSamples))
    ->Arg(static_cast<int>(NormalSource::kCoarseSamples))
    ->Unit(benchmark::kMillisecond);

// A tile's normals with some bits; none with 0.
struct ShadedTile {
  explicit ShadedTile(int normal_bits)
      : cut(surface(0.5)),
        mesh(index_triangles(cut.tiles.front().triangles, kDefaultLatticeResolution)),
        bits(normal_bits) {
    if (bits == 0) return;
    directions = vertex_normals(*dataset(), mesh.vertices, mesh.resolution, NormalSource::kSamples);
  }
  [[nodiscard]] EncodedTile encoded() const {
    return encode_tile(mesh, cut.tiles.front().cube, kDefaultEncodingSpeed,
                       {.directions = directions, .bits = bits});
  }

  CubeSurface cut;
  LatticeMesh mesh;
  int bits;
  std::vector<UnitVector> directions;
};

// The argument of this and the next is the bits of normals.
void tile_encoding(benchmark::State& state) {
  const ShadedTile tile(static_cast<int>(state.range(0)));
  std::int64_t bytes = 0;
  for (auto _ : state) bytes += tile.encoded().summary.bytes;
  const auto count = state.iterations() * static_cast<std::int64_t>(tile.mesh.triangles.size());
  state.SetItemsProcessed(count);
  state.counters["bytes_per_triangle"] = static_cast<double>(bytes) / static_cast<double>(count);
}
BENCHMARK(tile_encoding)->Arg(0)->Arg(8)->Arg(9)->Arg(10)->Unit(benchmark::kMillisecond);

// With all checks of arrival.
void tile_decoding(benchmark::State& state) {
  const ShadedTile shaded(static_cast<int>(state.range(0)));
  const EncodedTile tile = shaded.encoded();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        decode_tile(*tile.payload, tile.summary, kDefaultLatticeResolution, shaded.bits));
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<std::int64_t>(shaded.mesh.triangles.size()));
}
BENCHMARK(tile_decoding)->Arg(0)->Arg(8)->Arg(10)->Unit(benchmark::kMillisecond);

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

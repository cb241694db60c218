// Measures components on one thread, per sample or triangle, on a noisy head phantom of 128^3.

#include <array>
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

#include "server/core/errors/leaves.hpp"
#include "server/core/errors/own_error.hpp"
#include "server/core/spectrum/detail/own_error_curve.hpp"
#include "server/core/surface/tiling.hpp"
#include "server/core/surface/vertex_normals.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/volume/generators/generators.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

constexpr double kIsovalue = 500.5;

// Limits all work to one thread.
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

// Diamonds with values as noisy as the head's near its skull, and the distances from a cube's
// center to its corners.
class NoisyDiamonds {
 public:
  static constexpr std::size_t kCount = 1024;

  NoisyDiamonds() {
    for (std::size_t i = 0; i < 8; ++i) length_.set(i, std::sqrt(3.0));
    std::minstd_rand random(1);
    std::normal_distribution<double> value(kIsovalue, 60);
    for (DiamondValues<double>& diamond : diamonds_) {
      diamond.center = std::round(value(random));
      diamond.corners = 8;
      diamond.vectors = Lanes<double>::kVectors;
      diamond.ring_is_open = false;
      diamond.length = &length_;
      for (auto& lanes : diamond.value.vectors) lanes = all(diamond.center);
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

// All of `prepare`, into a temporary file: range, statistics, all errors. Items are voxels.
void spectrum_building(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    const auto source = source_of(head());
    state.ResumeTiming();
    benchmark::DoNotOptimize(make_dataset(*source, {.name = "head"}));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(head().size()));
}
BENCHMARK(spectrum_building)->Unit(benchmark::kMillisecond);

// The server's work for a request: errors from the spectrum, indexed tiles. Items are triangles;
// the argument is the error in hundredths of a voxel.
void prepared_extraction(benchmark::State& state) {
  const SurfaceExtractor extractor(dataset());
  const StepRequest step{
      .request = {.isovalue = kIsovalue, .error = static_cast<double>(state.range(0)) / 100}};
  std::int64_t count = 0;
  for (auto _ : state) {
    const TiledMesh surface = extractor.extract(step);
    for (const auto& tile : surface.tiles) {
      count += static_cast<std::int64_t>(tile.mesh.triangles.size());
    }
  }
  state.SetItemsProcessed(count);
}
BENCHMARK(prepared_extraction)->Arg(0)->Arg(50)->Arg(200)->Unit(benchmark::kMillisecond);

// A request with balls all over a grid of 512 steps, or a view.
IsosurfaceRequest mapped_request(std::int64_t regions, bool has_view) {
  IsosurfaceRequest request{.isovalue = kIsovalue, .error = 4};
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> coordinate(0, 512);
  std::uniform_real_distribution<double> number(0, 1);
  for (std::int64_t i = 0; i < regions; ++i) {
    request.thresholds.regions.push_back(
        {.shape = BallShape{.center = {coordinate(random), coordinate(random), coordinate(random)},
                            .radius = 30 * number(random)},
         .threshold = 4 * number(random)});
  }
  if (has_view) {
    request.thresholds.view = ThresholdView{.eye = {-300, 200, 100},
                                            .field_of_view = 40,
                                            .height_pixels = 1000,
                                            .tolerance_pixels = 2,
                                            .frustum = Frustum{.look_at = {256, 256, 256}}};
  }
  return request;
}
DatasetInfo info_of_512() {
  DatasetInfo info;
  info.dims = {513, 513, 513};
  info.grid_exponent = 9;
  return info;
}

// The least threshold around a point of the finest three spacings. Items are queries; arguments are
// the number of regions and whether there is a view.
void threshold_queries(benchmark::State& state) {
  const ThresholdMap map(mapped_request(state.range(0), state.range(1) != 0), info_of_512());
  std::minstd_rand random(2);
  std::vector<Box> boxes;
  for (int i = 0; i < 4096; ++i) {
    const std::int32_t spacing = 1 << (i % 3);
    const auto coordinate = [&] {
      return spacing *
             static_cast<std::int32_t>(1 + random() % (512U / static_cast<unsigned>(spacing) - 1));
    };
    boxes.push_back(region(DividingPoint({coordinate(), coordinate(), coordinate()})));
  }
  for (auto _ : state) {
    for (const Box& box : boxes) benchmark::DoNotOptimize(map.least_in(box));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(boxes.size()));
}
BENCHMARK(threshold_queries)
    ->ArgNames({"regions", "view"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({100, 0})
    ->Args({10000, 0})
    ->Args({0, 1})
    ->Args({10000, 1});

// Items are regions.
void threshold_map_building(benchmark::State& state) {
  const IsosurfaceRequest request = mapped_request(state.range(0), false);
  const DatasetInfo info = info_of_512();
  for (auto _ : state) benchmark::DoNotOptimize(ThresholdMap(request, info));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(threshold_map_building)->Arg(100)->Arg(10000)->Unit(benchmark::kMillisecond);

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
  auto count = static_cast<std::int64_t>(surface.rest.triangles.size());
  for (const auto& tile : surface.tiles)
    count += static_cast<std::int64_t>(tile.mesh.triangles.size());
  return count;
}

// With known errors, by the reference extractor. Items are triangles; the argument is the threshold
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
  const LatticeMesh& mesh = cut.tiles.front().mesh;
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

// A tile with normals of `normal_bits`; 0: without normals.
struct ShadedTile {
  explicit ShadedTile(int normal_bits)
      : cut(surface(0.5)), mesh(cut.tiles.front().mesh), bits(normal_bits) {
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

// The argument of this and the next benchmark is the bits of normals.
void tile_encoding(benchmark::State& state) {
  const ShadedTile tile(static_cast<int>(state.range(0)));
  std::int64_t bytes = 0;
  for (auto _ : state) bytes += tile.encoded().summary.bytes;
  const auto count = state.iterations() * static_cast<std::int64_t>(tile.mesh.triangles.size());
  state.SetItemsProcessed(count);
  state.counters["bytes_per_triangle"] = static_cast<double>(bytes) / static_cast<double>(count);
}
BENCHMARK(tile_encoding)->Arg(0)->Arg(8)->Arg(9)->Arg(10)->Unit(benchmark::kMillisecond);

// With all checks of received tiles.
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
  const CubeSurface cut = surface(0);
  std::vector<const LatticeMesh*> all = {&cut.rest};
  for (const TileMesh& tile : cut.tiles) all.push_back(&tile.mesh);
  const LatticeMesh mesh = weld(all, kDefaultLatticeResolution);
  for (auto _ : state) benchmark::DoNotOptimize(topology(mesh, {}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}
BENCHMARK(mesh_topology)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace multitetra

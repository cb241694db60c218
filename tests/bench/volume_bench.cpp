// Measures queries of a prepared dataset, compared with VTK's flying edges on the same samples.
//
//   volume_bench head.mtd --isovalue 500.5 --threads 1,2
//
// All measurements run round robin in one process, after one uncounted run of each, so that a busy
// moment of the machine affects all. The clock stops before results are freed. Extraction means
// indexed tiles in memory; only the file's pages and the verified checksums of its bricks are kept
// between runs.

#include <chrono>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <thread>

#include <nlohmann/json.hpp>

#include "common/base/in_parallel.hpp"
#include "common/cli/command_line.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/prepared_bricks.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/extraction/surface_sizes.hpp"
#include "tests/bench/flying_edges.hpp"
#include "tests/bench/volume_report.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra {
namespace {

struct Arguments {
  std::string file;
  double isovalue = 0;
  int runs = 5;
  std::vector<int> threads = {1, 2};
  bool json = false;
};

// The result of a run, kept until the clock has stopped.
struct Outcome {
  std::uint64_t triangles = 0;
  std::uint64_t encoded_bytes = 0;
  std::shared_ptr<const void> kept;
};

struct Work {
  std::string name;
  std::function<Outcome(int threads)> run;
};

constexpr double kEncodedError = 0.5;  // Voxels; the error of the encoded and previewed surface.

IsosurfaceRequest request_for(double isovalue, double error) {
  const auto request = validated(IsosurfaceRequest{.isovalue = isovalue, .error = error});
  if (!request) throw std::invalid_argument(request.error().text);
  return *request;
}

template <typename Body>
double seconds_of(const Body& body) {
  const auto begin = std::chrono::steady_clock::now();
  const auto result = body();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  return seconds.count();
}

std::uint64_t triangles_of(const TiledMesh& surface) {
  std::uint64_t count = 0;
  for (const TileMesh& tile : surface.tiles) count += tile.mesh.triangles.size();
  return count;
}

Outcome extract(const SurfaceExtractor& extractor, const StepRequest& step) {
  auto surface = std::make_shared<const TiledMesh>(extractor.extract(step));
  return {.triangles = triangles_of(*surface), .encoded_bytes = 0, .kept = std::move(surface)};
}

Outcome encode(std::shared_ptr<const TiledMesh> surface) {
  using Both = std::pair<std::shared_ptr<const TiledMesh>, std::vector<EncodedTile>>;
  const auto both = std::make_shared<const Both>(surface, testing::encode_tiles(*surface));
  Outcome outcome{.triangles = triangles_of(*surface), .encoded_bytes = 0, .kept = both};
  for (const EncodedTile& tile : both->second) outcome.encoded_bytes += tile.summary.bytes;
  return outcome;
}

std::optional<StepRequest> first_preview(const SurfaceExtractor& extractor, double isovalue) {
  const PlannedStep next = next_step(request_for(isovalue, kEncodedError), {}, {},
                                     extractor.dataset().info, surface_sizes(extractor), {});
  if (next.is_final) return std::nullopt;
  return next.step;
}

// Counted on a newly opened dataset.
std::optional<BrickReads> preview_reads(const Arguments& arguments) {
  const DatasetPtr dataset = open_dataset(arguments.file);
  const SurfaceExtractor extractor(dataset);
  const auto preview = first_preview(extractor, arguments.isovalue);
  const auto* samples = dynamic_cast<const PreparedBricks*>(dataset->samples.get());
  const auto* spectrum = dynamic_cast<const PreparedBricks*>(dataset->spectrum.bricks.get());
  if (!preview || samples == nullptr || spectrum == nullptr) return std::nullopt;
  (void)extractor.extract(*preview);
  return BrickReads{.sample_reads = samples->reads(),
                    .sample_bricks = samples->size(),
                    .spectrum_reads = spectrum->reads(),
                    .spectrum_bricks = spectrum->size()};
}

FlyingEdges::SamplePointer samples_of(const Volume& volume) {
  return std::visit([](const auto& samples) { return FlyingEdges::SamplePointer(samples.data()); },
                    volume.samples);
}

// The extractor must outlive the result.
std::vector<Work> works_of(const SurfaceExtractor& extractor, double isovalue) {
  std::vector<Work> works;
  const auto add_extraction = [&](const std::string& name, const StepRequest& step) {
    works.push_back({name, [&extractor, step](int) { return extract(extractor, step); }});
  };
  add_extraction("extract, error 0", {.request = request_for(isovalue, 0)});
  add_extraction("extract, error 0.5", {.request = request_for(isovalue, 0.5)});
  add_extraction("extract, error 2", {.request = request_for(isovalue, 2)});
  if (const auto preview = first_preview(extractor, isovalue)) {
    add_extraction("first preview", *preview);
    works.push_back({"first preview, planned and encoded", [&extractor, isovalue](int) {
                       const StepRequest step = first_preview(extractor, isovalue).value();
                       return encode(std::make_shared<const TiledMesh>(extractor.extract(step)));
                     }});
  }
  const auto surface = std::make_shared<const TiledMesh>(
      extractor.extract({.request = request_for(isovalue, kEncodedError)}));
  works.push_back({"encode, error 0.5", [surface](int) { return encode(surface); }});
  return works;
}

double seconds_of(const Work& work, int threads, Measurement& measurement) {
  const ThreadLimit limit(threads);
  return seconds_of([&] {
    Outcome outcome = work.run(threads);
    measurement.triangles = outcome.triangles;
    measurement.encoded_bytes = outcome.encoded_bytes;
    return outcome;
  });
}

// Runs all of them once to warm up and `runs` times to measure, alternating, because a repeated run
// would find its samples in the processor's cache.
std::vector<Measurement> measure(const std::vector<Work>& works, const Arguments& arguments) {
  std::vector<Measurement> measurements(works.size());
  for (std::size_t i = 0; i < works.size(); ++i) {
    measurements[i].work = works[i].name;
    measurements[i].timings.resize(arguments.threads.size());
  }
  for (int run = -1; run < arguments.runs; ++run) {
    for (std::size_t t = 0; t < arguments.threads.size(); ++t) {
      for (std::size_t i = 0; i < works.size(); ++i) {
        const double seconds = seconds_of(works[i], arguments.threads[t], measurements[i]);
        if (run >= 0) measurements[i].timings[t].seconds.push_back(seconds);
      }
    }
  }
  return measurements;
}

VolumeReport report_of(const Arguments& arguments) {
  VolumeReport report;
  Timing opening;
  for (int run = -1; run < arguments.runs; ++run) {
    const double seconds = seconds_of([&] { return open_dataset(arguments.file); });
    if (run >= 0) opening.seconds.push_back(seconds);
  }
  const DatasetPtr dataset = open_dataset(arguments.file);
  report.info = dataset->info;
  report.isovalue = arguments.isovalue;
  report.file_bytes = std::filesystem::file_size(arguments.file);
  report.open_seconds = opening.median();
  report.processors = static_cast<int>(std::thread::hardware_concurrency());
  report.threads = arguments.threads;
  report.preview = preview_reads(arguments);

  const SurfaceExtractor extractor(dataset);
  std::vector<Work> works = works_of(extractor, arguments.isovalue);
  Volume volume;
  std::unique_ptr<const FlyingEdges> flying_edges;
  if (FlyingEdges::is_available()) {
    volume = whole_volume(*dataset);
    flying_edges =
        std::make_unique<const FlyingEdges>(volume.dims, volume.spacing, samples_of(volume));
    for (const int threads : arguments.threads) {
      const ThreadLimit limit(threads);
      const auto surface = flying_edges->extract(arguments.isovalue, threads);
      report.flying_edges.push_back(FlyingEdges::version() + ", backend " + surface.backend +
                                    ", at most " + std::to_string(surface.threads) + " threads");
    }
    works.insert(works.begin(), {"flying edges", [&](int threads) {
                                   auto surface =
                                       flying_edges->extract(arguments.isovalue, threads);
                                   return Outcome{.triangles = surface.triangles,
                                                  .encoded_bytes = 0,
                                                  .kept = std::move(surface.mesh)};
                                 }});
  }
  report.measurements = measure(works, arguments);
  return report;
}

int run(int count, char** values) {
  Arguments arguments;
  Command program("Times answers about a prepared dataset beside VTK's flying edges",
                  "volume_bench");
  program.add_option("file", arguments.file, "Dataset file (.mtd)")->required();
  program.add_option("--isovalue", arguments.isovalue, "Isovalue of all surfaces")->required();
  program.add_option("--runs", arguments.runs, "Runs that are counted, of each")
      ->within(1, 1000)
      ->capture_default_str();
  program.add_option("--threads", arguments.threads, "Numbers of threads to compare")
      ->delimiter(',')
      ->within(1, 1024)
      ->capture_default_str();
  program.add_flag("--json", arguments.json, "Print a JSON report instead of the table");
  add_program_flags(program);
  if (const auto code = parse_command_line(program, count, values)) return *code;
  const VolumeReport report = report_of(arguments);
  std::cout << (arguments.json ? text_of(json_of(report)) : table_of(report));
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int count, char** values) {
  try {
    return multitetra::run(count, values);
  } catch (const std::exception& error) {
    std::cerr << "volume_bench: " << error.what() << "\n";
    return 1;
  }
}

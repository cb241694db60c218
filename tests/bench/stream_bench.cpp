// Measures the cost of a progressive stream: bytes and seconds of every step compared with the
// final step alone, and the accuracy of the estimates used for planning. Prints a row of a Markdown
// table per isovalue and error.
//
//   stream_bench head.mtd 500.5 1200.5 -- tooth.mtd 510.5
//   stream_bench --simplify head.mtd 500.5
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "server/dataset/dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/stream/stream_plan.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;

struct Row {
  std::vector<StepResult> steps;
  std::vector<double> seconds;  // From the request to each step, in the server.
  // The final step, requested alone.
  double alone_seconds = 0;
  struct Estimate {
    SurfaceSize size;
    double seconds = 0;
  };
  Estimate quick, accurate;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Row measure(const CachingSurfaceProvider& source, const IsosurfaceRequest& request) {
  Row row;
  Clock::time_point start = Clock::now();
  (void)make_next_step(source,
                       {.request = request, .steps = StepPolicy::kFinalOnly, .delivered = {}}, {});
  row.alone_seconds = seconds_since(start);
  const auto estimate = [&](SizeAccuracy accuracy) {
    start = Clock::now();
    const SurfaceSize size = source.sizes({}, accuracy).of({.request = request});
    return Row::Estimate{size, seconds_since(start)};
  };
  row.quick = estimate(SizeAccuracy::kQuick);
  row.accurate = estimate(SizeAccuracy::kAccurate);
  start = Clock::now();
  StreamState state{.request = request, .delivered = {}};
  while (row.steps.empty() || !row.steps.back().is_final) {
    StepResult made = make_next_step(source, state, {}).value();
    row.seconds.push_back(seconds_since(start));
    state = made.after;
    state.delivered.push_back({.step = made.step, .size = size_of(made.encoded)});
    row.steps.push_back(std::move(made));
  }
  return row;
}

void print(const std::string& name, double isovalue, double error, const Row& row) {
  const SurfaceSize last = size_of(row.steps.back().encoded);
  std::printf("| %s, %g | %g | ", name.c_str(), isovalue, error);
  double previews = 0;
  for (std::size_t i = 0; i + 1 < row.steps.size(); ++i) {
    const double bytes = size_of(row.steps[i].encoded).bytes;
    previews += bytes;
    std::printf("%s%d: %.1f KB (%.1f %%), %.0f ms", i == 0 ? "" : "; ",
                static_cast<int>(row.steps[i].step.finest_spacing), bytes / 1e3,
                100 * bytes / last.bytes, 1e3 * row.seconds[i]);
  }
  std::printf(" | %.1f KB, %.0f ms | %.1f %%, %.2f |", last.bytes / 1e3, 1e3 * row.seconds.back(),
              100 * previews / last.bytes, row.seconds.back() / row.alone_seconds);
  for (const auto& [size, seconds] : {row.accurate, row.quick}) {
    std::printf(" %.2f, %.2f, %.0f ms |", size.triangles / last.triangles, size.bytes / last.bytes,
                1e3 * seconds);
  }
  std::puts("");
  std::fflush(stdout);
}

void run(const std::string& file, const std::vector<double>& isovalues, bool simplify) {
  const DatasetPtr dataset = open_dataset(file);
  const CachingSurfaceProvider source(std::make_shared<const SurfaceExtractor>(dataset));
  for (const double isovalue : isovalues) {
    for (const double error : {0.25, 1.0, 2.0}) {
      print(dataset->info.name, isovalue, error,
            measure(source, {.isovalue = isovalue, .error = error, .simplify = simplify}));
    }
  }
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  std::puts(
      "| volume, isovalue | error, voxels | previews (finest spacing: bytes, of the final step's; "
      "time) | final step | previews' bytes; time to alone | estimate to real: triangles, bytes; "
      "time | quick estimate |");
  std::puts("| --- | --- | --- | --- | --- | --- | --- |");
  try {
    const bool simplify = argc > 1 && std::string(argv[1]) == "--simplify";
    for (int i = simplify ? 2 : 1; i < argc; ++i) {
      const std::string file = argv[i];
      std::vector<double> isovalues;
      while (++i < argc && std::string(argv[i]) != "--") isovalues.push_back(std::atof(argv[i]));
      multitetra::run(file, isovalues, simplify);
    }
  } catch (const std::exception& failure) {
    std::cerr << "stream_bench: " << failure.what() << "\n";
    return 1;
  }
  return 0;
}

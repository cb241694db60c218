// Measures the quality of the shown mesh over time: a server in this process streams surfaces never
// requested before, over links of several speeds, and a client assembles and checks them. Prints
// what was shown after 50, 100, 250 and 500 ms, 1 s, and at the end: the step's error, and its
// distance to the full-resolution surface in voxels (99 % of the samples, both ways).
//
//   quality_bench [--threads 2] [--errors 0.5,0] head.mtd 500.5 1200.5 -- female.mtd 300.5
//   quality_bench --json --links 0,10 --ways samples,display --no-distances head.mtd 500.5
//
// --json also prints a line of JSON per stream. --links are in Mbit/s, 0 for unlimited. --ways are
// the client's capabilities: "draco" decodes only Draco, "samples" also sample shells, "display"
// also keeps no mesh, and "viewer" also reports its speed.
//
// `certified` is the time and bytes until the first step within the error, with the topology of the
// full surface, is complete and checked.
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <tbb/global_control.h>
#include <nlohmann/json.hpp>

#include "server/dataset/dataset.hpp"
#include "tests/bench/measured_stream.hpp"
#include "tests/support/distance_statistics.hpp"

namespace multitetra {
namespace {

constexpr std::array kMoments = {0.05, 0.1, 0.25, 0.5, 1.0};
constexpr std::size_t kSamples = 20'000;

std::vector<SurfaceTriangle> triangles_of(const LatticeMesh& mesh) {
  std::vector<SurfaceTriangle> triangles;
  const double step = 1.0 / (1 << mesh.resolution);
  triangles.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    SurfaceTriangle corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& v = mesh.vertices[triangle[i]];
      corners[i] = {step * v.x, step * v.y, step * v.z};
    }
    triangles.push_back(corners);
  }
  return triangles;
}

// The full-resolution surface, in grid steps.
class FullSurface {
 public:
  FullSurface(const SurfaceExtractor& extractor, double isovalue)
      : triangles_(extracted(extractor, isovalue)), nearest_(triangles_) {}

  // Returns a distance that 99 % of the samples of each surface do not exceed to the other one.
  [[nodiscard]] double percentile_99(const CommittedStep& step) {
    const auto [known, is_new] = percentiles_.emplace(step.end.digest, 0);
    if (is_new) known->second = measured(step.mesh);
    return known->second;
  }

 private:
  static std::vector<SurfaceTriangle> extracted(const SurfaceExtractor& extractor,
                                                double isovalue) {
    std::vector<SurfaceTriangle> all;
    const StepRequest step = {.request = {.isovalue = isovalue, .error = 0}};
    for (const TileMesh& tile : extractor.extract(step).tiles) {
      const auto some = triangles_of(tile.mesh);
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }

  [[nodiscard]] double measured(const LatticeMesh& mesh) const {
    const auto shown = triangles_of(mesh);
    const auto no_limit = [](const Vec3&) { return std::numeric_limits<double>::infinity(); };
    const double there =
        distances(sampled_points(shown, kSamples), nearest_, no_limit).percentile_99;
    const double back =
        distances(sampled_points(triangles_, kSamples), NearestTriangle(shown), no_limit)
            .percentile_99;
    return std::max(there, back);
  }

  std::vector<SurfaceTriangle> triangles_;
  NearestTriangle nearest_;
  std::map<ContentDigest, double> percentiles_;  // By the step's digest.
};

std::string codec_of(const StepBegin& step) {
  if (!step.shell) return "draco";
  switch (step.shell->values) {
    case shell::ShellValues::kExact:
      return "samples, exact";
    case shell::ShellValues::kLatticeExact:
      return "samples, lattice-exact";
    case shell::ShellValues::kQuantized:
      break;
  }
  return "samples, L = " + std::to_string(step.shell->levels_per_octave);
}

std::string name_of(const StepBegin& step) {
  if (step.shell) {
    const int levels = step.shell->levels_per_octave;
    return std::to_string(step.finest_spacing) + "v" + (levels > 0 ? std::to_string(levels) : "");
  }
  return std::to_string(step.finest_spacing) +
         (step.request.simplify && !step.is_unsimplified ? "s" : "");
}

struct Arguments {
  std::size_t threads = 2;
  std::vector<double> errors = {0.5, 2};
  std::vector<double> links = {0, 1000, 100, 10, 1};  // Mbit/s.
  std::vector<ClientWay> ways = multitetra::ways();
  bool measures_distances = true;
  bool json = false;
};

std::string link_name(double megabits) {
  std::ostringstream text;
  if (megabits <= 0) return "unlimited";
  text << (megabits < 1000 ? megabits : megabits / 1000) << (megabits < 1000 ? " M" : " G")
       << "bit/s";
  return text.str();
}

// A stream and the distances of its steps to the full surface, in voxels.
struct Shown {
  std::string volume;
  std::string link;
  std::string way;
  IsosurfaceRequest request;
  MeasuredStream stream;
  std::vector<std::optional<double>> far;
  double voxel = 1;
};

void print_row(const Shown& shown) {
  const MeasuredStream& stream = shown.stream;
  std::printf("| %s, %g | %s, %s | %g |", shown.volume.c_str(), shown.request.isovalue,
              shown.link.c_str(), shown.way.c_str(), shown.request.error);
  if (const auto* step = certified_step(stream, shown.request.error * shown.voxel)) {
    std::printf(" %.3f s, %.0f KiB |", step->fetched.seconds,
                static_cast<double>(step->bytes_until_then) / 1024);
  } else {
    std::printf(" never |");
  }
  const auto cell = [&](std::size_t i) {
    std::printf(" %.3g;", stream[i].fetched.step->begin.error_bound_world / shown.voxel);
    shown.far[i] ? std::printf(" %.2f |", *shown.far[i]) : std::printf(" |");
  };
  for (const double moment : kMoments) {
    std::size_t count = 0;
    while (count < stream.size() && stream[count].fetched.seconds <= moment) ++count;
    count == 0 ? void(std::printf(" nothing |")) : cell(count - 1);
  }
  cell(stream.size() - 1);
  std::printf(" %.2f s |", stream.back().fetched.seconds);
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const CommittedStep& step = *stream[i].fetched.step;
    std::printf("%s %s: %zu, %.0f KB, %.0f ms (%.0f)", i == 0 ? "" : ";",
                name_of(step.begin).c_str(), step.mesh.triangles.size(),
                static_cast<double>(step.end.payload_bytes) / 1e3, 1e3 * stream[i].fetched.seconds,
                1e3 * step.end.seconds);
  }
  std::puts(" |");
}

nlohmann::json json_of(const Shown& shown, double megabits) {
  const auto* certified = certified_step(shown.stream, shown.request.error * shown.voxel);
  nlohmann::json report = {{"volume", shown.volume},
                           {"isovalue", shown.request.isovalue},
                           {"link", shown.link},
                           {"megabits_per_second", megabits},
                           {"client", shown.way},
                           {"error", shown.request.error},
                           {"certified_seconds", nullptr},
                           {"certified_bytes", nullptr},
                           {"steps", nlohmann::json::array()}};
  if (certified) {
    report["certified_seconds"] = certified->fetched.seconds;
    report["certified_bytes"] = certified->bytes_until_then;
  }
  for (std::size_t i = 0; i < shown.stream.size(); ++i) {
    const FetchedStep& fetched = shown.stream[i].fetched;
    const CommittedStep& step = *fetched.step;
    report["steps"].push_back({{"seconds", fetched.seconds},
                               {"first_byte_seconds", fetched.first_byte_seconds},
                               {"server_seconds", step.end.seconds},
                               {"bytes", step.end.payload_bytes},
                               {"bytes_until_then", shown.stream[i].bytes_until_then},
                               {"codec", codec_of(step.begin)},
                               {"finest_spacing", step.begin.finest_spacing},
                               {"error", step.begin.error_bound_world / shown.voxel},
                               {"keeps_topology", preserves_topology(step.begin)},
                               {"is_certified", &shown.stream[i] == certified},
                               {"is_final", step.begin.is_final},
                               {"triangles", step.mesh.triangles.size()},
                               {"p99", nullptr}});
    if (shown.far[i]) report["steps"].back()["p99"] = *shown.far[i];
  }
  return report;
}

void run(const std::string& file, double isovalue, const Arguments& with) {
  const auto extractor = std::make_shared<const SurfaceExtractor>(open_dataset(file));
  const DatasetInfo& info = extractor->dataset().info;
  std::optional<FullSurface> full;
  if (with.measures_distances) full.emplace(*extractor, isovalue);
  for (const double megabits : with.links) {
    for (const ClientWay& way : with.ways) {
      for (const double error : with.errors) {
        MeasuredServer server(extractor, with.threads, {.bytes_per_second = 1.25e5 * megabits},
                              way);
        // Requests a neighboring isovalue first, so that the server has estimates as in a drag.
        (void)server.stream({.isovalue = isovalue * 1.01, .error = 2, .simplify = true});
        Shown shown = {.volume = info.name,
                       .link = link_name(megabits),
                       .way = way.name,
                       .request = {.isovalue = isovalue, .error = error, .simplify = true},
                       .stream = {},
                       .far = {},
                       .voxel = voxel_length(info)};
        shown.stream = server.stream(shown.request);
        for (const MeasuredStep& step : shown.stream) {
          shown.far.push_back(full ? std::optional(full->percentile_99(*step.fetched.step))
                                   : std::nullopt);
        }
        print_row(shown);
        if (with.json) std::puts(json_of(shown, megabits).dump().c_str());
        std::fflush(stdout);
      }
    }
  }
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream text(list);
  for (std::string word; std::getline(text, word, ',');) words.push_back(word);
  return words;
}

std::vector<double> numbers(const std::string& list) {
  std::vector<double> all;
  for (const std::string& word : split(list)) all.push_back(std::stod(word));
  return all;
}

std::vector<ClientWay> ways_named(const std::string& list) {
  std::vector<ClientWay> named;
  for (const std::string& word : split(list)) {
    const auto way = std::find_if(ways().begin(), ways().end(),
                                  [&](const ClientWay& w) { return w.name == word; });
    if (way == ways().end()) throw std::runtime_error("no way is named " + word);
    named.push_back(*way);
  }
  return named;
}

int main_with(const std::vector<std::string>& words) {
  Arguments arguments;
  std::size_t i = 0;
  for (; i < words.size() && words[i].starts_with("--"); ++i) {
    if (words[i] == "--json") {
      arguments.json = true;
    } else if (words[i] == "--no-distances") {
      arguments.measures_distances = false;
    } else if (words[i] == "--threads" && i + 1 < words.size()) {
      arguments.threads = std::stoul(words[++i]);
    } else if (words[i] == "--errors" && i + 1 < words.size()) {
      arguments.errors = numbers(words[++i]);
    } else if (words[i] == "--links" && i + 1 < words.size()) {
      arguments.links = numbers(words[++i]);
    } else if (words[i] == "--ways" && i + 1 < words.size()) {
      arguments.ways = ways_named(words[++i]);
    } else {
      throw std::runtime_error("unknown option " + words[i]);
    }
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);
  std::puts(
      "| volume, isovalue | link, client | error | certified | after 50 ms: error; p99 | 100 ms | "
      "250 ms | 500 ms | 1 s | end | complete | steps (finest spacing, s: simplified, v: samples): "
      "triangles, bytes, there after (made in) |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
  while (i < words.size()) {
    const std::string file = words[i++];
    for (; i < words.size() && words[i] != "--"; ++i) run(file, std::stod(words[i]), arguments);
    ++i;
  }
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::main_with({argv + 1, argv + argc});
  } catch (const std::exception& failure) {
    std::cerr << "quality_bench: " << failure.what() << "\n";
    return 1;
  }
}

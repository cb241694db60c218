// The quality of the shown mesh over time: a server of this process streams surfaces that were
// never requested before, over links of several speeds, and a client assembles and checks them.
// Prints what was shown after 50, 100, 250 and 500 ms, a second, and at the end: the error that its
// step was made for, and its measured distance from the full-resolution surface (99 % of the
// samples, both ways, in voxels).
//
//   quality_bench [--threads 2] [--error 0.5] head.mtd 500.5 1200.5 -- female.mtd 300
//   quality_bench --json                   a line of JSON for every stream as well
//
// Every stream is fetched by a client that decodes Draco alone, by one that decodes sample shells,
// too, and by one that keeps no mesh. `certified` is when the first step that is within the error,
// with the topology of the full surface, is complete and checked, and how much had come by then.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "client/library/surface_stream.hpp"
#include "common/mesh/surface_distance.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/extracted_surfaces.hpp"
#include "tests/bench/shaped_link.hpp"
#include "tests/support/running_server.hpp"

namespace multitetra {
namespace {

constexpr std::array kMoments = {0.05, 0.1, 0.25, 0.5, 1.0};
constexpr std::size_t kSamples = 20'000;

struct Link {
  const char* name;
  double bytes_per_second;  // 0: as fast as this machine.
};
constexpr std::array kLinks = {Link{"unlimited", 0}, Link{"10 Mbit/s", 1.25e6},
                               Link{"1 Mbit/s", 1.25e5}};

template <typename T>
T value(ClientResult<T> result) {
  if (!result) throw std::runtime_error(result.error().error.text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

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

// The surface that every other one stands for, in grid steps.
class FullSurface {
 public:
  FullSurface(const SurfaceExtractor& extractor, double isovalue)
      : triangles_(extracted(extractor, isovalue)), nearest_(triangles_) {}

  // 99 % of the samples of each surface are nearer to the other one.
  [[nodiscard]] double percentile_99(const LatticeMesh& mesh) const {
    const auto shown = triangles_of(mesh);
    const auto no_limit = [](const Vec3&) { return std::numeric_limits<double>::infinity(); };
    const double there =
        distances(sampled_points(shown, kSamples), nearest_, no_limit).percentile_99;
    const double back =
        distances(sampled_points(triangles_, kSamples), NearestTriangle(shown), no_limit)
            .percentile_99;
    return std::max(there, back);
  }
  [[nodiscard]] std::size_t triangles() const { return triangles_.size(); }

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

  std::vector<SurfaceTriangle> triangles_;
  NearestTriangle nearest_;
};

struct Stream {
  std::vector<FetchedStep> steps;
};

struct Way {
  const char* name;
  std::vector<PayloadCodec> codecs;
  MeshUse use;
};
const std::vector<Way>& ways() {
  static const std::vector<PayloadCodec> kDraco = {PayloadCodec::kDracoLattice};
  static const std::vector<PayloadCodec> kBoth = ClientOptions{}.codecs;
  static const std::vector<Way> all = {{"draco", kDraco, MeshUse::kKeep},
                                       {"samples", kBoth, MeshUse::kKeep},
                                       {"display", kBoth, MeshUse::kDisplay}};
  return all;
}

Stream fetched(Client& client, const DatasetInfo& info, const IsosurfaceRequest& request,
               MeshUse use) {
  TileMemory tiles({.tiles = 4096, .triangles = 20'000'000});
  SurfaceStream stream(client, tiles);
  value(stream.open(info, {.dataset = info.name, .request = request, .held = {}, .use = use}));
  Stream all;
  for (;;) {
    StreamNews news = value(stream.next(std::chrono::seconds(10)));
    if (auto* step = std::get_if<FetchedStep>(&news)) all.steps.push_back(std::move(*step));
    if (std::holds_alternative<StreamIsOver>(news)) return all;
  }
}

std::string name_of(const StepBegin& step) {
  if (step.shell) {
    const int levels = step.shell->levels_per_octave;
    return std::to_string(step.finest_spacing) + "v" + (levels > 0 ? std::to_string(levels) : "");
  }
  return std::to_string(step.finest_spacing) +
         (step.request.simplify && !step.is_unsimplified ? "s" : "");
}

std::string certified_text(const Stream& stream, double error_world) {
  std::uint64_t bytes = 0;
  for (const FetchedStep& fetched : stream.steps) {
    const CommittedStep& step = *fetched.step;
    bytes += step.end.payload_bytes;
    if (!preserves_topology(step.begin) || step.begin.error_bound_world > error_world) continue;
    char text[64];
    std::snprintf(text, sizeof(text), "%.3f s, %.0f KiB", fetched.seconds,
                  static_cast<double>(bytes) / 1024);
    return text;
  }
  return "never";
}

void report(const std::string& volume, const std::string& link, const IsosurfaceRequest& request,
            const Stream& stream, const FullSurface& full, const DatasetInfo& info, bool json) {
  std::vector<double> far;
  for (const FetchedStep& step : stream.steps) far.push_back(full.percentile_99(step.step->mesh));
  const double voxel = voxel_length(info);
  std::printf("| %s, %g | %s | %g | %s |", volume.c_str(), request.isovalue, link.c_str(),
              request.error, certified_text(stream, request.error * voxel).c_str());
  const auto cell = [&](std::size_t i) {
    std::printf(" %.3g; %.2f |", stream.steps[i].step->begin.error_bound_world / voxel, far[i]);
  };
  for (const double moment : kMoments) {
    std::size_t shown = 0;
    while (shown < stream.steps.size() && stream.steps[shown].seconds <= moment) ++shown;
    if (shown == 0) {
      std::printf(" nothing |");
    } else {
      cell(shown - 1);
    }
  }
  cell(stream.steps.size() - 1);
  std::printf(" %.2f s |", stream.steps.back().seconds);
  for (std::size_t i = 0; i < stream.steps.size(); ++i) {
    const CommittedStep& step = *stream.steps[i].step;
    std::printf("%s %s: %zu, %.0f KB, %.0f ms (%.0f)", i == 0 ? "" : ";",
                name_of(step.begin).c_str(), step.mesh.triangles.size(),
                static_cast<double>(step.end.payload_bytes) / 1e3, 1e3 * stream.steps[i].seconds,
                1e3 * step.end.seconds);
  }
  std::puts(" |");
  if (json) {
    std::printf("{\"volume\":\"%s\",\"isovalue\":%g,\"link\":\"%s\",\"error\":%g,\"steps\":[",
                volume.c_str(), request.isovalue, link.c_str(), request.error);
    for (std::size_t i = 0; i < stream.steps.size(); ++i) {
      std::printf("%s{\"seconds\":%.4f,\"error\":%g,\"p99\":%.4f,\"triangles\":%zu}",
                  i == 0 ? "" : ",", stream.steps[i].seconds,
                  stream.steps[i].step->begin.error_bound_world / voxel, far[i],
                  stream.steps[i].step->mesh.triangles.size());
    }
    std::puts("]}");
  }
  std::fflush(stdout);
}

struct Arguments {
  std::size_t threads = 2;
  std::vector<double> errors = {0.5, 2};
  bool json = false;

  [[nodiscard]] static std::vector<std::pair<Link, Way>> streams() {
    std::vector<std::pair<Link, Way>> all;
    for (const Link& link : kLinks) {
      for (const Way& way : ways()) all.emplace_back(link, way);
    }
    return all;
  }
};

void run(const std::string& file, const std::vector<double>& isovalues, const Arguments& with) {
  const DatasetPtr dataset = open_dataset(file);
  const auto extractor = std::make_shared<const SurfaceExtractor>(dataset);
  const DatasetInfo& info = dataset->info;
  for (std::size_t i = 0; i < isovalues.size(); ++i) {
    const FullSurface full(*extractor, isovalues[i]);
    for (const auto& [link, way] : with.streams()) {
      // Nothing is remembered from one link to the next, but what triangles cost.
      auto catalogue = std::make_shared<DatasetCatalogue>();
      catalogue->add(std::make_shared<ExtractedSurfaces>(extractor));
      testing::RunningServer server(catalogue, {.service = {.workers = with.threads}});
      std::optional<ShapedLink> shaped;
      if (link.bytes_per_second > 0) shaped.emplace(server.endpoint(), link.bytes_per_second);
      Client client = value(
          Client::connect(shaped ? shaped->endpoint() : server.endpoint(), {.codecs = way.codecs}));
      (void)value(client.list_datasets());
      // A neighbouring isovalue first: the server then has the estimates that it has during a drag.
      (void)fetched(client, info, {.isovalue = isovalues[i] * 1.01, .error = 2, .simplify = true},
                    way.use);
      for (const double error : with.errors) {
        const IsosurfaceRequest request = {
            .isovalue = isovalues[i], .error = error, .simplify = true};
        report(info.name, std::string(link.name) + ", " + way.name, request,
               fetched(client, info, request, way.use), full, info, with.json);
      }
    }
  }
}

int main_with(const std::vector<std::string>& words) {
  Arguments arguments;
  std::size_t i = 0;
  for (; i < words.size() && words[i].starts_with("--"); ++i) {
    if (words[i] == "--json") {
      arguments.json = true;
    } else if (words[i] == "--threads" && i + 1 < words.size()) {
      arguments.threads = std::strtoul(words[++i].c_str(), nullptr, 10);
    } else if (words[i] == "--error" && i + 1 < words.size()) {
      arguments.errors = {std::atof(words[++i].c_str())};
    } else {
      throw std::runtime_error("unknown option " + words[i]);
    }
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);
  std::puts(
      "| volume, isovalue | link | error | certified | after 50 ms: error; p99 | 100 ms | 250 ms | "
      "500 ms | 1 "
      "s "
      "| end | complete | steps (finest spacing, s: simplified, v: samples): triangles, bytes, "
      "there after "
      "(made in) |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
  while (i < words.size()) {
    const std::string file = words[i++];
    std::vector<double> isovalues;
    while (i < words.size() && words[i] != "--") isovalues.push_back(std::atof(words[i++].c_str()));
    ++i;
    run(file, isovalues, arguments);
  }
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::main_with({argv + 1, argv + argc});
  } catch (const std::exception& trouble) {
    std::cerr << "quality_bench: " << trouble.what() << "\n";
    return 1;
  }
}

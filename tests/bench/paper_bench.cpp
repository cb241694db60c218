// Computes the tables and figures of Zhou, Chen and Kaufman 1997 for one prepared dataset. Used by
// paper.sh, which makes the page.
//
//   paper_bench head.mtd --isovalue 500.5 --largest-error 8 --step 0.25
//
// Prints JSON: seconds for the exact errors of one isovalue and of all isovalues; for each
// definition of the error, the tetrahedra and triangles by error; the paper's map of two halves;
// the results of other readings of the paper; and the triangles by isovalue.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <iostream>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/base/in_parallel.hpp"
#include "common/cli/command_line.hpp"
#include "common/json/json_report.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/errors/own_error.hpp"
#include "server/core/errors/saturated_errors.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/volume/volume_source.hpp"
#include "tests/bench/flying_edges.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

struct Arguments {
  std::string file;
  double isovalue = 0;
  double largest_error = 8;
  double step = 0.25;
  int runs = 3;
  std::vector<int> threads = {1, 2};
};

// Returns the minimum over all runs, which is the time without other load.
template <typename Body>
double least_seconds(int runs, int threads, const Body& body) {
  const ThreadLimit limit(threads);
  double least = 0;
  for (int run = 0; run < runs; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    const auto result = body();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    least = run == 0 ? seconds.count() : std::min(least, seconds.count());
  }
  return least;
}

SaturatedErrors exact_errors(const Field& field, double isovalue) {
  return {field, isovalue, ErrorMeasure::kPaper, TopologyRule::kPaper,
          [](std::size_t count, const std::function<void(std::size_t)>& body) {
            in_parallel(count, body, {});
          }};
}

Json times_of(const Arguments& arguments, const ReferenceExtractor& extractor,
              const PreparedVolume& dataset) {
  const Volume volume = whole_volume(dataset);
  Json times;
  for (const int threads : arguments.threads) {
    times.push_back(
        {{"threads", threads},
         {"exact_errors_seconds",
          least_seconds(arguments.runs, threads,
                        [&] { return exact_errors(extractor.field(), arguments.isovalue); })},
         {"all_isovalues_seconds", least_seconds(arguments.runs, threads, [&] {
            return make_dataset(
                *source_of(volume),
                {.name = "timed", .outside = dataset.info.outside, .margin = dataset.info.margin});
          })}});
  }
  return times;
}

Json counts_of(const ReferenceExtractor& extractor, const Model& model, double isovalue) {
  const TiledMesh surface = extractor.surface(model, {.isovalue = isovalue});
  std::uint64_t triangles = 0;
  for (const TileMesh& tile : surface.tiles) triangles += tile.mesh.triangles.size();
  return {{"tetrahedra", surface.tetrahedra},
          {"active_tetrahedra", surface.active_tetrahedra},
          {"triangles", triangles}};
}

struct Way {
  const char* name;
  ErrorMeasure error_measure;
  TopologyRule rule;
  bool from_spectrum;
};
constexpr Way kWays[] = {
    {"paper", ErrorMeasure::kPaper, TopologyRule::kPaper, false},
    {"certified", ErrorMeasure::kCertified, TopologyRule::kExact, false},
    {"spectrum", ErrorMeasure::kCertified, TopologyRule::kExact, true},
};

Json counts_of(const ReferenceExtractor& extractor, const PreparedVolume& dataset, const Way& way,
               IsosurfaceRequest request) {
  request.error_measure = way.error_measure;
  request.topology_rule = way.rule;
  const ResolvedStep spec = resolved_step({.request = request}, dataset.info);
  const auto model =
      way.from_spectrum ? extractor.spectrum_model(spec) : extractor.exact_model(spec);
  Json counts = {{"error", request.error}};
  counts.update(counts_of(extractor, *model, request.isovalue));
  return counts;
}

Json curves_of(const Arguments& arguments, const ReferenceExtractor& extractor,
               const PreparedVolume& dataset) {
  Json curves;
  for (const Way& way : kWays) {
    for (int i = 0; i * arguments.step <= arguments.largest_error; ++i) {
      curves[way.name].push_back(counts_of(
          extractor, dataset, way, {.isovalue = arguments.isovalue, .error = i * arguments.step}));
    }
  }
  return curves;
}

// Error 0 left of the grid's middle, 4 right of it.
Json halves_of(const Arguments& arguments, const ReferenceExtractor& extractor,
               const PreparedVolume& dataset) {
  const double middle =
      extractor.field().grid().side() / 2.0 - static_cast<double>(dataset.info.margin);
  IsosurfaceRequest request{.isovalue = arguments.isovalue, .error = 4};
  request.thresholds = {
      .coordinates = CoordinateSystem::kIndex,
      .regions = {
          {.shape = HalfSpaceShape{.normal = {-1, 0, 0}, .offset = -middle}, .threshold = 0}}};
  return counts_of(extractor, dataset, kWays[0], request);
}

// Another reading of the paper: the own error of a point with value m; v: mean of its edge's ends.
struct Reading {
  const char* name;
  double (*own_error)(const OwnError& error, double m, double v, double isovalue);
};
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr Reading kReadings[] = {
    // Ours.
    {"flips",
     [](const OwnError& e, double, double, double) { return e.flip ? kNever : e.displacement; }},
    // No point may change its side.
    {"sides", [](const OwnError& e, double m, double v,
                 double c) { return (m > c) != (v > c) ? kNever : e.displacement; }},
    // Crossings that appear or vanish cost nothing.
    {"appearing_is_free",
     [](const OwnError& e, double m, double v, double c) {
       return e.flip ? kNever : (m > c) != (v > c) ? 0 : e.displacement;
     }},
    // Any change of the field, for all isovalues.
    {"lossless", [](const OwnError&, double m, double v, double) { return m == v ? 0 : kNever; }},
};

// The paper's model with any own error.
class ReadModel final : public Model {
 public:
  ReadModel(const Field& field, double isovalue, const Reading& reading) : grid_(field.grid()) {
    const std::int32_t side = grid_.side();
    const auto count = static_cast<std::size_t>(side) + 1;
    errors_.resize(count * count * count);
    field.visit([&](const auto& sampled) {
      for (std::int32_t spacing = 1; spacing < side; spacing *= 2) {
        const GridStepLengths lengths(field.spacing());
        for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
          for_points(spacing, kind, [&](const DividingPoint& p) {
            const auto [a, b] = p.split_edge();
            const OwnError own = own_error(sampled, grid_, lengths, p, isovalue);
            const double mean =
                0.5 * (static_cast<double>(sampled.at(a)) + static_cast<double>(sampled.at(b)));
            double& error = errors_[index(p.at())];
            error = std::max(error, reading.own_error(own, static_cast<double>(sampled.at(p.at())),
                                                      mean, isovalue));
            for (const GridPoint parent : p.parents(grid_)) {
              errors_[index(parent)] = std::max(errors_[index(parent)], error);
            }
          });
        }
      }
    });
  }
  void allow(double threshold) { threshold_ = threshold; }
  [[nodiscard]] bool kept(const DividingPoint& point) const override {
    return errors_[index(point.at())] > threshold_;
  }

 private:
  [[nodiscard]] std::size_t index(GridPoint p) const {
    const auto count = static_cast<std::size_t>(grid_.side()) + 1;
    return static_cast<std::size_t>(p.x) +
           count * (static_cast<std::size_t>(p.y) + count * static_cast<std::size_t>(p.z));
  }
  template <typename Visit>
  void for_points(std::int32_t spacing, PointKind kind, const Visit& visit) const {
    for (std::int32_t z = 0; z <= grid_.side(); z += spacing) {
      for (std::int32_t y = 0; y <= grid_.side(); y += spacing) {
        for (std::int32_t x = 0; x <= grid_.side(); x += spacing) {
          if (((x | y | z) & spacing) == 0) continue;
          const DividingPoint p({x, y, z});
          if (p.kind() == kind) visit(p);
        }
      }
    }
  }

  Grid grid_;
  std::vector<double> errors_;
  double threshold_ = 0;
};

Json readings_of(const Arguments& arguments, const ReferenceExtractor& extractor) {
  Json readings;
  for (const Reading& reading : kReadings) {
    ReadModel model(extractor.field(), arguments.isovalue, reading);
    for (const double error : {0.0, 1.5, 2.5, 4.0}) {
      model.allow(error);
      Json counts = {{"error", error}};
      counts.update(counts_of(extractor, model, arguments.isovalue));
      readings[reading.name].push_back(counts);
    }
  }
  return readings;
}

// Returns the triangles of full-resolution surfaces over the range of values.
Json triangles_by_isovalue(const ReferenceExtractor& extractor, const PreparedVolume& dataset) {
  constexpr int kIsovalues = 40;
  Json sizes;
  for (int i = 0; i < kIsovalues; ++i) {
    const double share = (i + 0.5) / kIsovalues;
    const double isovalue =
        std::floor(dataset.info.min + share * (dataset.info.max - dataset.info.min)) + 0.5;
    const Json counts = counts_of(extractor, dataset, kWays[0], {.isovalue = isovalue, .error = 0});
    sizes.push_back({{"isovalue", isovalue}, {"triangles", counts["triangles"]}});
  }
  return sizes;
}

// Runs flying edges on the volume without its padding.
Json flying_edges_of(const Arguments& arguments, const PreparedVolume& dataset) {
  if (!FlyingEdges::is_available()) return nullptr;
  const Volume volume = whole_volume(dataset);
  const FlyingEdges flying_edges(
      volume.dims, volume.spacing,
      std::visit([](const auto& samples) { return FlyingEdges::SamplePointer(samples.data()); },
                 volume.samples));
  return {{"triangles", flying_edges.extract(arguments.isovalue, 1).triangles}};
}

Json report_of(const Arguments& arguments) {
  const DatasetPtr dataset = open_dataset(arguments.file);
  const ReferenceExtractor extractor(*dataset);
  const auto side = static_cast<std::uint64_t>(extractor.field().grid().side());
  Json report = {{"name", dataset->info.name},
                 {"dims", dataset->info.dims},
                 {"isovalue", arguments.isovalue},
                 {"grid_points_a_side", side + 1},
                 {"all_tetrahedra", 6 * side * side * side},
                 {"processors", std::thread::hardware_concurrency()}};
  report["times"] = times_of(arguments, extractor, *dataset);
  report["curves"] = curves_of(arguments, extractor, *dataset);
  report["halves"] = halves_of(arguments, extractor, *dataset);
  report["readings"] = readings_of(arguments, extractor);
  report["triangles_by_isovalue"] = triangles_by_isovalue(extractor, *dataset);
  report["flying_edges"] = flying_edges_of(arguments, *dataset);
  return report;
}

int run(int count, char** values) {
  Arguments arguments;
  Command program("Counts and times beside those of Zhou, Chen and Kaufman 1997", "paper_bench");
  program.add_option("file", arguments.file, "Dataset file (.mtd)")->required();
  program.add_option("--isovalue", arguments.isovalue, "Isovalue")->required();
  program.add_option("--largest-error", arguments.largest_error, "Voxels")
      ->within(0.0, 1024.0)
      ->capture_default_str();
  program.add_option("--step", arguments.step, "Between two errors")
      ->within(0.01, 1024.0)
      ->capture_default_str();
  program.add_option("--runs", arguments.runs, "Of what is timed; the least counts")
      ->within(1, 100)
      ->capture_default_str();
  program.add_option("--threads", arguments.threads, "Numbers of threads to time")->delimiter(',');
  add_program_flags(program);
  if (const auto code = parse_command_line(program, count, values)) return *code;
  std::cout << text_of(report_of(arguments));
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "paper_bench: " << error.what() << "\n";
    return 1;
  }
}

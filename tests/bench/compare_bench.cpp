// One surface by our streams and by other software: bytes, triangles and seconds from the isovalue
// to the encoded mesh, against the measured distance to the full-resolution surface. Used by
// compare.sh, which makes the page.
//
//   compare_bench head.mtd --isovalue 500.5 --errors 0.1,0.25,0.5,1,2,4
//
// Prints JSON, including the seconds that a client takes to decode. Ours are sample shells or Draco
// tiles, with positions in steps of 1/32 voxel; the others are encoded by Draco or meshoptimizer,
// with 14 bits over the bounding box. Distances are sampled both ways, in voxels and (except for
// shells) before encoding, to the full-resolution surface of marching tetrahedra. Flying edges
// interpolates differently between samples, so distances to its surface are listed too.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/base/in_parallel.hpp"
#include "common/cli/command_line.hpp"
#include "common/json/json_report.hpp"
#include "common/mesh/surface_distance.hpp"
#include "common/wire/shell_tile.hpp"
#include "common/wire/tile.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/shell_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/programs/thread_options.hpp"
#include "tests/bench/flying_edges.hpp"
#include "tests/bench/mesh_codecs.hpp"
#include "tests/bench/mesh_shape.hpp"
#include "tests/bench/open_vdb.hpp"
#include "tests/support/distance_statistics.hpp"
#include "tests/support/tiled_surfaces.hpp"

namespace multitetra {
namespace {

struct Arguments {
  std::string file;
  double isovalue = 0;
  std::vector<double> errors = {0.1, 0.25, 0.5, 1, 2, 4};
  std::vector<double> adaptivities = {0, 0.05, 0.2, 0.5, 1};
  int runs = 3;
  int threads = 2;
  std::size_t samples = 20000;
};

// The result of one run of a method.
struct Made {
  PlainMesh mesh;  // Voxels, the first sample at the origin.
  std::uint64_t bytes = 0;
  std::function<void()> decode;  // The client's work.
};

struct Method {
  std::string name;
  std::string setting;
  std::optional<double> certified = {};  // The certified distance before rounding, in voxels.
  // The largest distance inside the data at which the surface may end, in voxels.
  double border = 0;
  std::function<Made()> make;
};

std::vector<SurfaceTriangle> soup_of(const PlainMesh& mesh) {
  std::vector<SurfaceTriangle> soup;
  soup.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    SurfaceTriangle triangle;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& p = mesh.positions[t[i]];
      triangle[i] = {static_cast<double>(p[0]), static_cast<double>(p[1]),
                     static_cast<double>(p[2])};
    }
    soup.push_back(triangle);
  }
  return soup;
}

Made sent_by_draco(PlainMesh mesh) {
  EncodedMesh encoded = encoded_by_draco(mesh);
  return {.mesh = std::move(mesh), .bytes = encoded.bytes, .decode = std::move(encoded.decode)};
}
Made sent_by_meshoptimizer(PlainMesh mesh) {
  EncodedMesh encoded = encoded_by_meshoptimizer(mesh);
  return {.mesh = std::move(mesh), .bytes = encoded.bytes, .decode = std::move(encoded.decode)};
}

// --- ours

struct DracoStep {
  const char* name;
  bool simplify;
  bool embedded;
};
constexpr std::array kDracoSteps = {DracoStep{"ours", true, false},
                                    DracoStep{"ours, embedded", true, true},
                                    DracoStep{"ours, unsimplified", false, false}};

PlainMesh plain(const std::vector<LatticeMesh>& tiles, const Vec3& voxels) {
  const LatticeMesh mesh = weld(tiles, kDefaultLatticeResolution);
  PlainMesh result;
  for (const LatticePoint& p : mesh.vertices) {
    const Vec3 x = grid_coordinates(p, mesh.resolution);
    result.positions.push_back({static_cast<float>(x[0] * voxels[0]),
                                static_cast<float>(x[1] * voxels[1]),
                                static_cast<float>(x[2] * voxels[2])});
  }
  result.triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
  return result;
}

std::vector<LatticeMesh> meshes_of(TiledMesh surface) {
  std::vector<LatticeMesh> meshes;
  for (TileMesh& tile : surface.tiles) meshes.push_back(std::move(tile.mesh));
  return meshes;
}

std::uint64_t bytes_of(const std::vector<EncodedTile>& tiles) {
  std::uint64_t bytes = 0;
  for (const EncodedTile& tile : tiles) bytes += tile.summary.bytes;
  return bytes;
}

// Decodes as clients do, checking each tile against the manifest.
std::vector<LatticeMesh> decoded_draco_tiles(const std::vector<EncodedTile>& tiles) {
  std::vector<LatticeMesh> meshes;
  for (const EncodedTile& tile : tiles) {
    meshes.push_back(decode_tile(*tile.payload, tile.summary, kDefaultLatticeResolution).value());
  }
  return meshes;
}

std::vector<LatticeMesh> decoded_shell_tiles(const std::vector<EncodedTile>& tiles,
                                             const ShellStep& shell) {
  std::vector<LatticeMesh> meshes(tiles.size());
  in_parallel(tiles.size(), [&](std::size_t i) {
    meshes[i] = decode_shell_tile(*tiles[i].payload, tiles[i].summary, {.shell = shell}).value();
  });
  return meshes;
}

// --- peers

// All samples, or means of blocks of n^3.
struct Samples {
  std::array<std::int32_t, 3> dims;
  std::vector<float> values;
};

Samples samples_of(const Volume& volume) {
  Samples samples{.dims = volume.dims, .values = {}};
  std::visit([&](const auto& values) { samples.values.assign(values.begin(), values.end()); },
             volume.samples);
  return samples;
}

Samples means_of(const Samples& fine, std::int32_t n) {
  Samples coarse{.dims = {fine.dims[0] / n, fine.dims[1] / n, fine.dims[2] / n}, .values = {}};
  const auto row = static_cast<std::size_t>(fine.dims[0]);
  const auto slice = row * static_cast<std::size_t>(fine.dims[1]);
  for (std::int32_t z = 0; z < coarse.dims[2]; ++z) {
    for (std::int32_t y = 0; y < coarse.dims[1]; ++y) {
      for (std::int32_t x = 0; x < coarse.dims[0]; ++x) {
        double sum = 0;
        for (std::int32_t i = 0; i < n * n * n; ++i) {
          const auto at = [n](std::int32_t block, std::int32_t offset) {
            return static_cast<std::size_t>(block * n + offset);
          };
          sum += static_cast<double>(
              fine.values[at(x, i % n) + row * at(y, i / n % n) + slice * at(z, i / (n * n))]);
        }
        coarse.values.push_back(static_cast<float>(sum / (n * n * n)));
      }
    }
  }
  return coarse;
}

// The samples must outlive the result.
std::function<PlainMesh()> flying_edges_of(const Samples& samples, std::int32_t n,
                                           const Vec3& voxels, double isovalue, int threads) {
  const std::array<double, 3> spacing = {n * voxels[0], n * voxels[1], n * voxels[2]};
  const auto flying_edges =
      std::make_shared<const FlyingEdges>(samples.dims, spacing, samples.values.data());
  return [flying_edges, n, voxels, isovalue, threads] {
    PlainMesh mesh = FlyingEdges::mesh_of(flying_edges->extract(isovalue, threads));
    for (auto& p : mesh.positions) {  // A mean lies in the center of its block.
      for (std::size_t axis = 0; axis < 3; ++axis) {
        p[axis] += static_cast<float>(voxels[axis] * (n - 1) / 2);
      }
    }
    return mesh;
  };
}

std::string decimal(double number) {
  std::string text = std::to_string(number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

// --- measuring

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// A surface that others are compared with.
class Reference {
 public:
  Reference(const PlainMesh& mesh, std::size_t samples) : Reference(soup_of(mesh), samples) {}

  // Returns the larger of the distances in both directions, and the mean of both means.
  [[nodiscard]] Json distances_of(const PlainMesh& mesh) const {
    std::vector<SurfaceTriangle> soup = soup_of(mesh);
    const std::vector<Vec3> points = sampled_points(soup, points_.size());
    const NearestTriangle surface(std::move(soup));
    const auto anything = [](const Vec3&) { return 1e300; };
    const DistanceStatistics there = distances(points, surface_, anything);
    const DistanceStatistics back = distances(points_, surface, anything);
    return {{"largest", std::max(there.maximum, back.maximum)},
            {"percentile_99", std::max(there.percentile_99, back.percentile_99)},
            {"mean", (there.mean + back.mean) / 2}};
  }

 private:
  Reference(std::vector<SurfaceTriangle> soup, std::size_t samples)
      : points_(sampled_points(soup, samples)), surface_(std::move(soup)) {}

  std::vector<Vec3> points_;
  NearestTriangle surface_;
};

class Comparison {
 public:
  explicit Comparison(const Arguments& arguments)
      : arguments_(arguments),
        dataset_(open_dataset(arguments.file)),
        extractor_(std::make_shared<const SurfaceExtractor>(dataset_)) {
    const DatasetInfo& info = dataset_->info;
    if (info.outside || info.margin != 0) {
      throw std::invalid_argument(
          "The dataset has a value or a margin around its samples, which the peers cannot see; "
          "prepare it without --pad-value and --pad.");
    }
    const double voxel = voxel_length(info);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      voxels_[axis] = info.spacing[axis] / voxel;
      high_[axis] = (info.dims[axis] - 1) * voxels_[axis];
    }
  }

  Json report() {
    const IsosurfaceRequest whole = {.isovalue = arguments_.isovalue, .error = 0};
    const PlainMesh full = plain(meshes_of(extractor_->extract({.request = whole})), voxels_);
    full_.emplace(full, arguments_.samples);
    const Shape shape = shape_of(full, high_, 0);
    Json report = {{"name", dataset_->info.name},
                   {"dims", dataset_->info.dims},
                   {"isovalue", arguments_.isovalue},
                   {"threads", arguments_.threads},
                   {"full_surface",
                    {{"triangles", full.triangles.size()},
                     {"euler_characteristic", shape.euler_characteristic},
                     {"components", shape.components}}},
                   {"peers", Json::array()}};
    for (const Method& method : ours()) report["rows"].push_back(row_of(method));

    const Samples samples = samples_of(whole_volume(*dataset_));
    add_flying_edges(report, samples);
    if (OpenVdbVolume::is_available()) {
      report["peers"].push_back(OpenVdbVolume::version());
      add_open_vdb(report, samples);
    }
    return report;
  }

 private:
  [[nodiscard]] std::vector<Method> ours() const {
    std::vector<Method> methods;
    for (const auto& [name, simplify, embedded] : kDracoSteps) {
      for (const double error : arguments_.errors) {
        const IsosurfaceRequest step = {.isovalue = arguments_.isovalue,
                                        .error = error,
                                        .simplify = simplify,
                                        .intersection_free = embedded};
        methods.push_back({.name = name,
                           .setting = "error " + decimal(error),
                           .certified = error,
                           .make = [this, step] { return draco_step(step); }});
      }
    }
    for (const auto& [name, shell] : shell_steps()) {
      const ShellLevel level = {.isovalue = arguments_.isovalue, .shell = shell};
      if (!has_shells(dataset_->info, level)) continue;
      const double moved = error_bound(shell, dataset_->info, 1);
      methods.push_back({.name = "ours, samples",
                         .setting = name,
                         .certified = moved / voxel_length(dataset_->info),
                         .make = [this, level] { return shell_step(level); }});
    }
    return methods;
  }

  [[nodiscard]] Made draco_step(const IsosurfaceRequest& request) const {
    TiledMesh surface = extractor_->extract({.request = request});
    const auto tiles =
        std::make_shared<const std::vector<EncodedTile>>(testing::encode_tiles(surface));
    stop_clock();
    return {.mesh = plain(meshes_of(std::move(surface)), voxels_),
            .bytes = bytes_of(*tiles),
            .decode = [tiles] { (void)decoded_draco_tiles(*tiles); }};
  }

  [[nodiscard]] Made shell_step(const ShellLevel& level) const {
    const auto tiles =
        std::make_shared<const std::vector<EncodedTile>>(extract_shells(*dataset_, level));
    stop_clock();
    return {.mesh = plain(decoded_shell_tiles(*tiles, level.shell), voxels_),
            .bytes = bytes_of(*tiles),
            .decode = [tiles, level] { (void)decoded_shell_tiles(*tiles, level.shell); }};
  }

  // Returns the step with the vertices of the full surface, and those that move them.
  [[nodiscard]] std::vector<std::pair<std::string, ShellStep>> shell_steps() const {
    std::vector<std::pair<std::string, ShellStep>> steps;
    if (dataset_->info.type != SampleType::kF32) {
      steps.push_back({"exact", {.values = shell::ShellValues::kExact}});
    }
    steps.push_back({"lattice-exact", {.values = shell::ShellValues::kLatticeExact}});
    for (const int levels : {8, 4, 2, 1}) {
      steps.push_back({"L = " + std::to_string(levels), quantized_shells(levels)});
    }
    return steps;
  }

  void add_flying_edges(Json& report, const Samples& samples) {
    if (!FlyingEdges::is_available()) return;
    report["peers"].push_back(FlyingEdges::version());
    const auto full = flying_edges_of(samples, 1, voxels_, arguments_.isovalue, arguments_.threads);
    flying_edges_.emplace(full(), arguments_.samples);
    report["rows"].push_back(row_of(
        {.name = "flying edges", .setting = "all", .make = [&] { return sent_by_draco(full()); }}));
    for (const std::int32_t n : {2, 4}) {
      const Samples means = means_of(samples, n);
      const auto coarse =
          flying_edges_of(means, n, voxels_, arguments_.isovalue, arguments_.threads);
      report["rows"].push_back(row_of({.name = "flying edges, downsampled",
                                       .setting = std::to_string(n) + " x",
                                       .border = 1.5 * n,
                                       .make = [&] { return sent_by_draco(coarse()); }}));
    }
    report["peers"].push_back(meshoptimizer_version());
    report["rows"].push_back(row_of({.name = "flying edges, meshopt codec",
                                     .setting = "all",
                                     .make = [&] { return sent_by_meshoptimizer(full()); }}));
    for (const double error : arguments_.errors) {
      const auto simplified = [&, error] { return simplified_by_meshoptimizer(full(), error); };
      report["rows"].push_back(row_of({.name = "flying edges, meshoptimizer",
                                       .setting = "error " + decimal(error),
                                       .border = 1e-3,
                                       .make = [&] { return sent_by_draco(simplified()); }}));
      report["rows"].push_back(
          row_of({.name = "flying edges, meshoptimizer, meshopt codec",
                  .setting = "error " + decimal(error),
                  .border = 1e-3,
                  .make = [&] { return sent_by_meshoptimizer(simplified()); }}));
    }
  }

  void add_open_vdb(Json& report, const Samples& samples) {
    const OpenVdbVolume volume(samples.dims, samples.values);
    for (const double adaptivity : arguments_.adaptivities) {
      report["rows"].push_back(row_of({.name = "OpenVDB",
                                       .setting = "adaptivity " + decimal(adaptivity),
                                       .border = 1,
                                       .make = [&, adaptivity] {
                                         PlainMesh mesh =
                                             volume.mesh(arguments_.isovalue, adaptivity);
                                         for (auto& p : mesh.positions) {
                                           for (std::size_t axis = 0; axis < 3; ++axis) {
                                             p[axis] *= static_cast<float>(voxels_[axis]);
                                           }
                                         }
                                         return sent_by_draco(std::move(mesh));
                                       }}));
    }
  }

  // Call before work that is only part of the comparison.
  void stop_clock() const { stopped_ = std::chrono::steady_clock::now(); }

  [[nodiscard]] Json row_of(const Method& method) const {
    const ThreadLimit limit(arguments_.threads);
    double least = 0;
    std::vector<double> decode_seconds;
    Made made;
    for (int run = 0; run < arguments_.runs; ++run) {
      const auto begin = std::chrono::steady_clock::now();
      stopped_.reset();
      made = method.make();
      if (!stopped_) stop_clock();
      const std::chrono::duration<double> seconds = *stopped_ - begin;
      least = run == 0 ? seconds.count() : std::min(least, seconds.count());
      decode_seconds.push_back(seconds_of(made.decode));
    }
    const Shape shape = shape_of(made.mesh, high_, method.border);
    Json row = {{"method", method.name},
                {"setting", method.setting},
                {"seconds", least},
                {"decode_seconds", *std::ranges::min_element(decode_seconds)},
                {"triangles", made.mesh.triangles.size()},
                {"bytes", made.bytes},
                {"distance", full_->distances_of(made.mesh)},
                {"open_edges", shape.open_edges},
                {"nonmanifold_edges", shape.nonmanifold_edges},
                {"euler_characteristic", shape.euler_characteristic},
                {"components", shape.components}};
    if (method.certified) row["certified"] = *method.certified;
    if (flying_edges_) row["distance_to_flying_edges"] = flying_edges_->distances_of(made.mesh);
    return row;
  }

  Arguments arguments_;
  DatasetPtr dataset_;
  std::shared_ptr<const SurfaceExtractor> extractor_;
  Vec3 voxels_ = {};  // The size of a sample.
  Vec3 high_ = {};    // The last sample.
  std::optional<Reference> full_;
  // At full resolution, to compare the other software with.
  std::optional<Reference> flying_edges_;
  mutable std::optional<std::chrono::steady_clock::time_point> stopped_;
};

int run(int count, char** values) {
  Arguments arguments;
  Command program("A surface by our streams and by what people use instead", "compare_bench");
  program.add_option("file", arguments.file, "Dataset file (.mtd)")->required();
  program.add_option("--isovalue", arguments.isovalue, "Isovalue")->required();
  program.add_option("--errors", arguments.errors, "Voxels, of ours and of meshoptimizer")
      ->delimiter(',');
  program.add_option("--adaptivities", arguments.adaptivities, "0 to 1, of OpenVDB")
      ->delimiter(',');
  program.add_option("--runs", arguments.runs, "The least time of them counts")
      ->within(1, 100)
      ->capture_default_str();
  add_threads_option(program, arguments.threads);
  add_program_flags(program);
  if (const auto code = parse_command_line(program, count, values)) return *code;
  std::cout << text_of(Comparison(arguments).report());
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "compare_bench: " << error.what() << "\n";
    return 1;
  }
}

// One surface by our streams and by other software: bytes, triangles and seconds from "isovalue
// named" to "encoded mesh", against the real distance to the full-resolution surface. A part of
// compare.sh, which makes the page.
//
//   compare_bench head.mtd --isovalue 500.5 --errors 0.1,0.25,0.5,1,2,4
//
// Prints JSON. All meshes are compressed by Draco, positions in steps of 1/32 voxel (ours) or not
// much finer (14 bits over the bounding box). Distances are sampled both ways, in voxels and before
// encoding, to the surface that marching tetrahedra makes at full resolution. Flying edges
// interpolates differently between the samples, so the other programs' distances to its surface are
// listed as well.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <exception>
#include <functional>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/cli/command_line.hpp"
#include "common/cli/json_report.hpp"
#include "common/mesh/surface_distance.hpp"
#include "common/wire/tile.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/programs/thread_options.hpp"
#include "tests/bench/flying_edges.hpp"
#include "tests/bench/open_vdb.hpp"

#ifdef MULTITETRA_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

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

constexpr int kPeerBits = 14;

// What one run of a method gives.
struct Made {
  PlainMesh mesh;  // Voxels, the first sample at the origin.
  std::uint64_t bytes = 0;
};

struct Method {
  std::string name;
  std::string setting;
  double border = 0;  // How far inside the data its surface may end, voxels.
  std::function<Made()> make;
};

// How a mesh hangs together; vertices are the same when their indices are.
struct Shape {
  std::int64_t open_edges = 0;  // That do not lie on the data's border.
  std::int64_t nonmanifold_edges = 0;
  std::int64_t euler_characteristic = 0;
  std::int64_t components = 0;
};

// Whether both places lie on one side of the data's box, or up to `depth` inside of it.
bool on_border(const std::array<float, 3>& p, const std::array<float, 3>& q, const Vec3& high,
               double depth) {
  constexpr double kRounding = 1e-3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double a = p[axis];
    const double b = q[axis];
    if (std::max(a, b) <= depth + kRounding) return true;
    if (std::min(a, b) >= high[axis] - depth - kRounding) return true;
  }
  return false;
}

Shape shape_of(const PlainMesh& mesh, const Vec3& high, double border) {
  std::vector<std::uint32_t> group(mesh.positions.size());
  std::iota(group.begin(), group.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (group[v] != v) v = group[v] = group[group[v]];
    return v;
  };
  std::vector<bool> is_used(mesh.positions.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i];
      const std::uint32_t b = t[(i + 1) % 3];
      is_used[a] = true;
      group[root(a)] = root(b);
      edges.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  Shape shape;
  std::int64_t distinct = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j] == edges[i]) ++j;
    ++distinct;
    const auto& [a, b] = edges[i];
    if (j - i == 1 && !on_border(mesh.positions[a], mesh.positions[b], high, border)) {
      ++shape.open_edges;
    }
    if (j - i > 2) ++shape.nonmanifold_edges;
    i = j;
  }
  std::int64_t vertices = 0;
  for (std::uint32_t v = 0; v < is_used.size(); ++v) {
    if (!is_used[v]) continue;
    ++vertices;
    if (root(v) == v) ++shape.components;
  }
  shape.euler_characteristic =
      vertices - distinct + static_cast<std::int64_t>(mesh.triangles.size());
  return shape;
}

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

std::uint64_t encoded_bytes(const PlainMesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  return encode_draco_file({.positions = mesh.positions, .triangles = mesh.triangles}, kPeerBits)
      .size();
}

Made encoded(PlainMesh mesh) {
  const std::uint64_t bytes = encoded_bytes(mesh);
  return {.mesh = std::move(mesh), .bytes = bytes};
}

// --- ours

PlainMesh plain(const TiledSurface& surface, const Vec3& voxels) {
  std::vector<const LatticeMesh*> tiles;
  for (const TileMesh& tile : surface.tiles) tiles.push_back(&tile.mesh);
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

// --- peers

// All samples as they are, and as the means of blocks of n^3.
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

// The samples must outlive what is returned.
std::function<PlainMesh()> flying_edges_of(const Samples& samples, std::int32_t n,
                                           const Vec3& voxels, double isovalue, int threads) {
  const std::array<double, 3> spacing = {n * voxels[0], n * voxels[1], n * voxels[2]};
  const auto flying_edges =
      std::make_shared<const FlyingEdges>(samples.dims, spacing, samples.values.data());
  return [flying_edges, n, voxels, isovalue, threads] {
    PlainMesh mesh = FlyingEdges::mesh_of(flying_edges->extract(isovalue, threads));
    for (auto& p : mesh.positions) {  // A mean lies in the middle of its block.
      for (std::size_t axis = 0; axis < 3; ++axis) {
        p[axis] += static_cast<float>(voxels[axis] * (n - 1) / 2);
      }
    }
    return mesh;
  };
}

#ifdef MULTITETRA_HAS_MESHOPTIMIZER
PlainMesh simplified(const PlainMesh& mesh, double error) {
  if (mesh.triangles.empty()) return mesh;
  std::vector<unsigned> indices;
  for (const auto& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const float* const positions = mesh.positions.front().data();
  const std::size_t stride = sizeof(mesh.positions.front());
  const float scale = meshopt_simplifyScale(positions, mesh.positions.size(), stride);
  std::vector<unsigned> left(indices.size());
  left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(), positions,
                               mesh.positions.size(), stride, 0, static_cast<float>(error) / scale,
                               0, nullptr));
  PlainMesh result;  // Only the vertices that are left.
  std::vector<std::uint32_t> number(mesh.positions.size(), ~0U);
  for (std::size_t i = 0; i < left.size(); i += 3) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t j = 0; j < 3; ++j) {
      std::uint32_t& at = number[left[i + j]];
      if (at == ~0U) {
        at = static_cast<std::uint32_t>(result.positions.size());
        result.positions.push_back(mesh.positions[left[i + j]]);
      }
      triangle[j] = at;
    }
    result.triangles.push_back(triangle);
  }
  return result;
}
#endif

std::string decimal(double number) {
  std::string text = std::to_string(number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

// --- measuring

// A surface that others are compared with.
class Reference {
 public:
  Reference(const PlainMesh& mesh, std::size_t samples) : Reference(soup_of(mesh), samples) {}

  // The worse of both ways, the mean of both means.
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
          "prepare it without --outside and --margin.");
    }
    const double voxel = voxel_length(info);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      voxels_[axis] = info.spacing[axis] / voxel;
      high_[axis] = (info.dims[axis] - 1) * voxels_[axis];
    }
  }

  Json report() {
    const PlainMesh full = plain(extractor_->extract({.request = request(0, false)}), voxels_);
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
  [[nodiscard]] IsosurfaceRequest request(double error, bool simplify) const {
    return {.isovalue = arguments_.isovalue, .error = error, .simplify = simplify};
  }

  [[nodiscard]] std::vector<Method> ours() const {
    std::vector<Method> methods;
    for (const bool simplify : {true, false}) {
      for (const double error : arguments_.errors) {
        methods.push_back({.name = simplify ? "ours" : "ours, unsimplified",
                           .setting = "error " + decimal(error),
                           .make = [this, error, simplify] {
                             const TiledSurface surface =
                                 extractor_->extract({.request = request(error, simplify)});
                             Made made;
                             for (const EncodedTile& tile : encode_tiles(surface)) {
                               made.bytes += tile.summary.bytes;
                             }
                             stop_clock();
                             made.mesh = plain(surface, voxels_);
                             return made;
                           }});
      }
    }
    return methods;
  }

  void add_flying_edges(Json& report, const Samples& samples) {
    if (!FlyingEdges::is_available()) return;
    report["peers"].push_back(FlyingEdges::version());
    const auto full = flying_edges_of(samples, 1, voxels_, arguments_.isovalue, arguments_.threads);
    flying_edges_.emplace(full(), arguments_.samples);
    report["rows"].push_back(row_of(
        {.name = "flying edges", .setting = "all", .make = [&] { return encoded(full()); }}));
    for (const std::int32_t n : {2, 4}) {
      const Samples means = means_of(samples, n);
      const auto coarse =
          flying_edges_of(means, n, voxels_, arguments_.isovalue, arguments_.threads);
      report["rows"].push_back(row_of({.name = "flying edges, downsampled",
                                       .setting = std::to_string(n) + " x",
                                       .border = 1.5 * n,
                                       .make = [&] { return encoded(coarse()); }}));
    }
#ifdef MULTITETRA_HAS_MESHOPTIMIZER
    report["peers"].push_back("meshoptimizer " + std::to_string(MESHOPTIMIZER_VERSION));
    for (const double error : arguments_.errors) {
      report["rows"].push_back(
          row_of({.name = "flying edges, meshoptimizer",
                  .setting = "error " + decimal(error),
                  .border = 1e-3,
                  .make = [&, error] { return encoded(simplified(full(), error)); }}));
    }
#endif
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
                                         return encoded(std::move(mesh));
                                       }}));
    }
  }

  // What follows is for the comparison alone.
  void stop_clock() const { stopped_ = std::chrono::steady_clock::now(); }

  [[nodiscard]] Json row_of(const Method& method) const {
    const ThreadLimit limit(arguments_.threads);
    double least = 0;
    Made made;
    for (int run = 0; run < arguments_.runs; ++run) {
      const auto begin = std::chrono::steady_clock::now();
      stopped_.reset();
      made = method.make();
      if (!stopped_) stop_clock();
      const std::chrono::duration<double> seconds = *stopped_ - begin;
      least = run == 0 ? seconds.count() : std::min(least, seconds.count());
    }
    const Shape shape = shape_of(made.mesh, high_, method.border);
    Json row = {{"method", method.name},
                {"setting", method.setting},
                {"seconds", least},
                {"triangles", made.mesh.triangles.size()},
                {"bytes", made.bytes},
                {"distance", full_->distances_of(made.mesh)},
                {"open_edges", shape.open_edges},
                {"nonmanifold_edges", shape.nonmanifold_edges},
                {"euler_characteristic", shape.euler_characteristic},
                {"components", shape.components}};
    if (flying_edges_) row["distance_to_flying_edges"] = flying_edges_->distances_of(made.mesh);
    return row;
  }

  Arguments arguments_;
  DatasetPtr dataset_;
  std::shared_ptr<const SurfaceExtractor> extractor_;
  Vec3 voxels_ = {};  // A sample's size.
  Vec3 high_ = {};    // The last sample.
  std::optional<Reference> full_;
  std::optional<Reference> flying_edges_;  // At full resolution; for peers.
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

// Compares simplification with meshoptimizer's simplifier on the same surface, and with the stream
// without simplification at the same total error: triangles, Draco bytes, processor seconds of all
// threads, distances to the full-resolution surface in voxels, topology.
//
//   simplification_bench head.mtd 500.5 250000 0.125,0.375 0.25,0.25
//
// Arguments: the dataset, the isovalue, the most triangles of a tile for meshoptimizer before
// simplification (ours are divided by the simplified size), and pairs of errors: the model's and
// simplification's.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/wire/tile.hpp"
#include "server/core/simplification/simplification.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/detail/simplified_surface.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "tests/support/distance_statistics.hpp"

#include <meshoptimizer.h>

namespace multitetra {
namespace {

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Totals {
  double triangles = 0, bytes = 0, seconds = 0, encode_seconds = 0, bound = 0, input = 0;
};

std::vector<SurfaceTriangle> placed(const LatticeMesh& mesh, const Vec3& step) {
  std::vector<SurfaceTriangle> out;
  for (const TriangleIndices& t : mesh.triangles) {
    SurfaceTriangle s;
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint& p = mesh.vertices[t[i]];
      s[i] = {step[0] * p.x, step[1] * p.y, step[2] * p.z};
    }
    out.push_back(s);
  }
  return out;
}

LatticeMesh peer(const LatticeMesh& mesh, [[maybe_unused]] const Vec3& step,
                 [[maybe_unused]] double budget) {
  std::vector<float> positions;
  const LatticePoint o = mesh.vertices.front();
  for (const LatticePoint& p : mesh.vertices) {
    positions.push_back(static_cast<float>(step[0] * (p.x - o.x)));
    positions.push_back(static_cast<float>(step[1] * (p.y - o.y)));
    positions.push_back(static_cast<float>(step[2] * (p.z - o.z)));
  }
  std::vector<unsigned> indices;
  for (const TriangleIndices& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const float scale = meshopt_simplifyScale(positions.data(), mesh.vertices.size(), 12);
  std::vector<unsigned> result(indices.size());
  float error = 0;
  result.resize(meshopt_simplify(result.data(), indices.data(), indices.size(), positions.data(),
                                 mesh.vertices.size(), 12, 0, static_cast<float>(budget) / scale,
                                 meshopt_SimplifyLockBorder, &error));
  std::vector<LatticeTriangle> triangles;
  for (std::size_t i = 0; i < result.size(); i += 3) {
    triangles.push_back(
        {mesh.vertices[result[i]], mesh.vertices[result[i + 1]], mesh.vertices[result[i + 2]]});
  }
  return index_triangles(triangles, mesh.resolution);
}

void report(const char* name, const Totals& t, const Totals& base,
            const std::vector<LatticeMesh>& meshes, const Vec3& step,
            const std::vector<SurfaceTriangle>& full, const DataBorder& border) {
  const LatticeMesh whole = weld(meshes, meshes.front().resolution);
  const MeshTopology top = topology(whole, border);
  auto soup = placed(whole, step);
  const auto there = sampled_points(soup, 20000);
  const auto back = sampled_points(full, 20000);
  const NearestTriangle a(full), b(std::move(soup));
  const auto limit = [](const Vec3&) { return 1e9; };
  const auto d1 = distances(there, a, limit), d2 = distances(back, b, limit);
  std::printf(
      "%-9s tri %9.0f (%.3f) bytes %9.0f (%.3f) %.2f B/t | simplify %.3f s (%.2f M in/s) encode "
      "%.3f s | bound %.3f "
      "max %.3f %.3f p99 %.3f %.3f mean %.3f | euler %ld comp %ld open %ld nonman %ld\n",
      name, t.triangles, t.triangles / base.triangles, t.bytes, t.bytes / base.bytes,
      t.bytes / t.triangles, t.seconds, t.input / t.seconds / 1e6, t.encode_seconds, t.bound,
      d1.maximum, d2.maximum, d1.percentile_99, d2.percentile_99, (d1.mean + d2.mean) / 2,
      top.euler_characteristic, top.components, top.open_edges, top.nonmanifold_edges);
  std::fflush(stdout);
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  using namespace multitetra;
  if (argc < 5) return 1;
  const DatasetPtr dataset = open_dataset(argv[1]);
  const DatasetInfo& info = dataset->info;
  const double isovalue = std::atof(argv[2]);
  const std::size_t max_triangles = static_cast<std::size_t>(std::atol(argv[3]));
  const ReferenceExtractor extractor(*dataset);
  const double voxel = voxel_length(info);
  const double delta = 1.0 / (1 << kDefaultLatticeResolution);
  const Vec3 step = {delta * info.spacing[0] / voxel, delta * info.spacing[1] / voxel,
                     delta * info.spacing[2] / voxel};
  const auto surface = [&](double error, std::size_t max) {
    const StepRequest request{.request = {.isovalue = isovalue, .error = error}};
    const auto model = extractor.exact_model(resolved_step(request, info));
    return extractor.surface(*model, {.isovalue = isovalue, .max_triangles = max});
  };
  std::vector<SurfaceTriangle> full;
  for (const TileMesh& t : surface(0, 16000).tiles) {
    const auto p = placed(t.mesh, step);
    full.insert(full.end(), p.begin(), p.end());
  }
  const DataBorder border = data_border(info, kDefaultLatticeResolution, 0);
  for (int i = 4; i < argc; ++i) {
    double model_error = 0, budget = 0;
    if (std::sscanf(argv[i], "%lf,%lf", &model_error, &budget) != 2) return 1;
    std::printf("== model %.3f simplification %.3f, tiles of %zu\n", model_error, budget,
                max_triangles);
    Totals plain, small, theirs;
    std::vector<LatticeMesh> before, after, other;
    // The unsimplified stream at the total error.
    for (const TileMesh& t : surface(model_error + budget, 16000).tiles) {
      const double start = cpu();
      plain.bytes += encode_tile(t.mesh, t.cube).summary.bytes;
      plain.encode_seconds += cpu() - start;
      plain.triangles += static_cast<double>(t.mesh.triangles.size());
      before.push_back(t.mesh);
    }
    report("plain", plain, plain, before, step, full, border);
    Totals input;
    TiledMesh model = surface(model_error, 16000);
    for (const TileMesh& t : model.tiles) {
      input.triangles += static_cast<double>(t.mesh.triangles.size());
    }
    const double begin = cpu();
    SurfaceSimplifier simplifier(step, info.grid_exponent);
    const SimplificationOptions how{.lattice_step = step, .max_distance = budget};
    for (TileMesh& tile : model.tiles) simplifier.add(std::move(tile), how, {});
    const SimplificationWork work = simplifier.simplify(how, {});
    model.tiles = simplifier.tiles();
    small.seconds = cpu() - begin;
    std::printf("simplification: %.3f s of work, longest chain %.3f s (1/%.1f)\n", work.seconds,
                work.longest_chain, work.seconds / work.longest_chain);
    for (TileMesh& t : model.tiles) {
      const double start = cpu();
      small.bytes += encode_tile(t.mesh, t.cube, kSimplifiedEncodingSpeed).summary.bytes;
      small.encode_seconds += cpu() - start;
      small.triangles += static_cast<double>(t.mesh.triangles.size());
      small.bound = std::max(small.bound, t.simplification_bound);
      after.push_back(std::move(t.mesh));
    }
    for (const TileMesh& t : surface(model_error, max_triangles).tiles) {
      double start = cpu();
      LatticeMesh p = peer(t.mesh, step, budget);
      theirs.seconds += cpu() - start;
      if (!p.triangles.empty()) {
        start = cpu();
        theirs.bytes += encode_tile(p, t.cube, kSimplifiedEncodingSpeed).summary.bytes;
        theirs.encode_seconds += cpu() - start;
        theirs.triangles += static_cast<double>(p.triangles.size());
        other.push_back(std::move(p));
      }
    }
    std::printf("input of simplification: %.0f triangles\n", input.triangles);
    small.input = theirs.input = input.triangles;
    report("simplified", small, plain, after, step, full, border);
    if (!other.empty()) report("peer", theirs, plain, other, step, full, border);
  }
  return 0;
}

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include "common/wire/tile.hpp"
#include "server/core/simplification/simplification.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/simplified_surface.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/extraction/reference_extractor.hpp"
using namespace multitetra;
static double cpu() { timespec t{}; clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); return double(t.tv_sec) + 1e-9 * double(t.tv_nsec); }
static double wall() { timespec t{}; clock_gettime(CLOCK_MONOTONIC, &t); return double(t.tv_sec) + 1e-9 * double(t.tv_nsec); }
int main(int argc, char** argv) {
  const DatasetPtr dataset = open_dataset(argv[1]);
  const DatasetInfo& info = dataset->info;
  const double isovalue = std::atof(argv[2]);
  const ReferenceExtractor extractor(*dataset);
  const double voxel = voxel_length(info);
  const double delta = 1.0 / (1 << kDefaultLatticeResolution);
  const Vec3 step = {delta * info.spacing[0] / voxel, delta * info.spacing[1] / voxel, delta * info.spacing[2] / voxel};
  const char* ps = getenv("PIECE");
  for (int i = 3; i < argc; ++i) {
    double me = 0, budget = 0;
    if (std::sscanf(argv[i], "%lf,%lf", &me, &budget) != 2) return 1;
    const StepRequest request{.request = {.isovalue = isovalue, .error = me}};
    const auto m = extractor.exact_model(step_spec(request, info));
    const TiledSurface model = extractor.surface(*m, {.isovalue = isovalue, .max_triangles = ps ? size_t(atol(ps)) : 16000});
    double in = 0; for (auto& t : model.tiles) in += double(t.mesh.triangles.size());
    double best = 1e9, bw = 1e9; TiledSurface s;
    const char* rs = getenv("REPS");
    for (int r = 0; r < (rs ? atoi(rs) : 3); ++r) {
      s = model; double b = cpu(), w = wall();
      simplify(s, info.grid_exponent, [&](const OctreeCube&) { return SimplificationOptions{.lattice_step = step, .max_distance = budget}; }, {});
      best = std::min(best, cpu() - b); bw = std::min(bw, wall() - w);
    }
    double tri = 0, bytes = 0, bound = 0;
    for (auto& t : s.tiles) { tri += double(t.mesh.triangles.size()); bytes += double(encode_tile(t.mesh, t.cube, kSimplifiedEncodingSpeed).summary.bytes); bound = std::max(bound, t.simplification_bound); }
    std::printf("%s in %.0f tiles %zu tri %.0f bytes %.0f bound %.4f cpu %.3f (%.3f M/s) wall %.3f\n", argv[i], in, s.tiles.size(), tri, bytes, bound, best, in / best / 1e6, bw);
  }
}

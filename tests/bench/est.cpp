#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <string>
#include "server/dataset/dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/extraction/surface_sizes.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/shading.hpp"
#include "common/mesh/mesh_checks.hpp"
using namespace multitetra;
static double cpu() { timespec t{}; clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); return double(t.tv_sec) + 1e-9 * double(t.tv_nsec); }
// est vol iso...
int main(int argc, char** argv) {
  const DatasetPtr dataset = open_dataset(argv[1]);
  const DatasetInfo& info = dataset->info;
  const SurfaceExtractor extractor(dataset);
  std::map<std::string, std::array<double, 2>> known;
  { std::ifstream f("/tmp/actual.txt"); std::string k; double a, b; while (f >> k >> a >> b) known[k] = {a, b}; }
  for (int i = 2; i < argc; ++i) {
    for (double e : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0}) {
      StepRequest step{.request = {.isovalue = atof(argv[i]), .error = e, .simplify = true}};
      const std::string key = std::string(argv[1]) + ":" + argv[i] + ":" + std::to_string(e);
      if (!known.count(key)) { if (!getenv("MAKE")) continue;
        const StepSpec spec = step_spec(step, info, {});
        const TiledSurface s = extractor.extract(spec);
        const Shading shading(*dataset, step);
        double t = 0, b = 0;
        for (auto& tile : s.tiles) { auto x = shading.encoded(tile, digest(tile.mesh)).summary; t += double(x.triangles); b += double(x.bytes); }
        known[key] = {t, b};
        std::ofstream("/tmp/actual.txt", std::ios::app) << key << " " << t << " " << b << "\n";
      }
      const auto a = known[key];
      double t0 = cpu();
      const SurfaceSize c = surface_sizes(extractor, {}, SizeAccuracy::kCareful).of(step);
      double tc = cpu() - t0; t0 = cpu();
      const SurfaceSize q = surface_sizes(extractor, {}, SizeAccuracy::kQuick).of(step);
      double tq = cpu() - t0;
      std::printf("%-40s %8.0f tri  careful %.2f bytes %.2f (%.0f ms)  quick %.2f (%.0f ms) in %.0f\n", key.substr(9).c_str(), a[0], c.triangles / a[0], c.bytes / a[1], tc * 1e3, q.triangles / a[0], tq * 1e3, c.extracted); fflush(stdout);
    }
  }
}

// Compares the surfaces of datasets with those of the same datasets without errors, as they are
// served while their errors are computed. Prints Markdown: triangles, and ratios of tetrahedra and
// of CPU time without to with errors.
//
//   without_errors_bench head.mtd 500.5 -- female.mtd -300.5 300.5
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "server/extraction/surface_extractor.hpp"

namespace multitetra {
namespace {

struct Measured {
  std::size_t triangles = 0;
  double tetrahedra = 0;
  double seconds = 0;  // CPU time, the least of some runs.
};

Measured measured(const DatasetPtr& dataset, const IsosurfaceRequest& request) {
  constexpr int kRuns = 3;
  Measured result;
  for (int run = 0; run < kRuns; ++run) {
    const std::clock_t begin = std::clock();
    const TiledMesh surface = SurfaceExtractor(dataset).extract({.request = request});
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    result.seconds = run == 0 ? seconds : std::min(result.seconds, seconds);
    result.tetrahedra = static_cast<double>(surface.tetrahedra);
    result.triangles = 0;
    for (const TileMesh& tile : surface.tiles) result.triangles += tile.mesh.triangles.size();
  }
  return result;
}

void print_rows(const std::string& file, double isovalue) {
  const DatasetPtr dataset = open_dataset(file);
  const auto without_errors = std::make_shared<PreparedVolume>(*dataset);
  without_errors->spectrum.bricks = nullptr;
  for (const double error : {0.5, 2.0, 8.0}) {
    for (const bool simplify : {false, true}) {
      const IsosurfaceRequest request = {
          .isovalue = isovalue, .error = error, .simplify = simplify};
      const Measured with = measured(dataset, request);
      const Measured without = measured(without_errors, request);
      std::printf("| %s, %g | %g%s | %zu | %zu | %.4f | %.2f |\n", dataset->info.name.c_str(),
                  isovalue, error, simplify ? ", simplified" : "", with.triangles,
                  without.triangles, without.tetrahedra / with.tetrahedra,
                  without.seconds / with.seconds);
      std::fflush(stdout);
    }
  }
}

int main_with(const std::vector<std::string>& words) {
  std::puts("| volume, isovalue | error | triangles | without errors | tetrahedra | CPU time |");
  std::puts("| --- | --- | --- | --- | --- | --- |");
  std::string file;
  for (const std::string& word : words) {
    if (word == "--") {
      file.clear();
    } else if (file.empty()) {
      file = word;
    } else {
      print_rows(file, std::stod(word));
    }
  }
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) try {
  return multitetra::main_with({argv + 1, argv + argc});
} catch (const std::exception& problem) {
  std::cerr << problem.what() << "\n";
  return 1;
}

// Estimated triangles of a dataset's surfaces, over its isovalues and for several errors,
// without extracting them.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "server/core/planning/surface_size.hpp"

namespace multitetra {

class SurfaceExtractor;

struct SizeCurves {
  std::vector<double> isovalues;  // Ascending.
  // In voxels, as requested.
  std::vector<double> errors;
  std::vector<std::vector<double>> triangles;  // By error, then by isovalue.
};

// `count` isovalues spread evenly over the range of values; of integer data between two integers,
// each once, so there may be fewer. None when all samples are equal.
[[nodiscard]] std::vector<double> even_isovalues(const DatasetInfo& info, std::size_t count);

struct SizeCurvesOptions {
  // The cubes of the sample at each isovalue and error.
  std::size_t cubes = 256;
  bool simplify = false;  // Count what simplification leaves, as some blocks show.
  std::function<void(std::size_t done, std::size_t all)> progress =
      {};  // Isovalues; one call at a time.
};

// With the certified bound and the exact rule of topology. From the error spectrum and, for what is
// finer than it, a sample of the surface's octree cubes: the same numbers for the same dataset,
// with any number of threads. A larger error never has more triangles.
[[nodiscard]] SizeCurves size_curves(const SurfaceExtractor& extractor,
                                     std::vector<double> isovalues, std::vector<double> errors,
                                     const SizeCurvesOptions& options = {});

}  // namespace multitetra

// Estimates the triangles of a dataset's surfaces over its isovalues and for several errors,
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
  // Requested errors, in voxels.
  std::vector<double> errors;
  std::vector<std::vector<double>> triangles;  // Indexed by error, then isovalue.
};

// Returns `count` isovalues, evenly spaced over the range of values. For integer data they are
// midpoints between integers without repetition, so there may be fewer. Empty if all samples are
// equal.
[[nodiscard]] std::vector<double> even_isovalues(const DatasetInfo& info, std::size_t count);

struct SizeCurvesOptions {
  // Sampled cubes per isovalue and error.
  std::size_t cubes = 256;
  // Count triangles after simplification, estimated from blocks.
  bool simplify = false;
  // Receives numbers of isovalues; calls are serialized.
  std::function<void(std::size_t done, std::size_t all)> progress = {};
};

// Uses the certified bound and the exact topology rule. Estimates from the error spectrum and,
// below its spacing, from a sample of the surface's octree cubes. Deterministic for a dataset, with
// any number of threads. A larger error never has more triangles.
[[nodiscard]] SizeCurves size_curves(const SurfaceExtractor& extractor,
                                     std::vector<double> isovalues, std::vector<double> errors,
                                     const SizeCurvesOptions& options = {});

}  // namespace multitetra

// Estimates the size of a model's surface without extracting it: counted in a sample of its octree
// cubes.
//
// Cubes of more than 16 steps are few; their own tetrahedra are marched one and all. Of the refined
// cubes of 16 steps a regular sample is taken in octree order, which is spread over the whole
// surface, and what is found there stands for the others. The pieces here are pure and may run on
// any threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/fine_errors/prepared_model.hpp"
#include "server/core/surface/tiling.hpp"

namespace multitetra {

// The cubes whose surface is counted, and how many cubes each one stands for.
struct CubeSample {
  static constexpr int kExponent = kSpectrumExponent + 1;

  // Cubes of kExponent.
  std::vector<OctreeCube> cubes;
  double weight = 1;                    // At least 1.
  std::uint64_t coarse_tetrahedra = 0;  // Crossed ones that belong to larger cubes.
};

// At most `count` cubes; all of them, when there are no more. Reads no samples. `checkpoint` is
// called for every cube that is looked at; what it throws ends the search. Requires a grid of more
// than kSpectrumSpacing steps a side.
[[nodiscard]] CubeSample sample_cubes(
    const PreparedModel& model, std::size_t count, double isovalue,
    const std::function<void()>& checkpoint = [] {});

// The tetrahedra of one such cube that the surface crosses.
[[nodiscard]] std::uint64_t crossed_tetrahedra(const PreparedModel& model, const OctreeCube& cube,
                                               double isovalue, CubeMemory& memory);

// Triangles for every crossed tetrahedron: some have a triangle, some a quad. Measured 1.30 to 1.32
// on all volumes.
inline constexpr double kTrianglesATetrahedron = 1.31;

// Calls `visit` for the refined cubes of that exponent, at least kSpectrumExponent + 1, in octree
// order; what it throws ends the visit. Looks at the spectrum alone, and takes a small part of the
// time of everything else here.
void visit_refined_cubes(const PreparedModel& model, int exponent,
                         const std::function<void(const OctreeCube&)>& visit);

}  // namespace multitetra

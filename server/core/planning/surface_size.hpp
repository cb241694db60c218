// Estimates the size of a model's surface without extracting it, from a sample of its octree cubes.
//
// Cubes of more than 16 steps are few; the surface in all their own tetrahedra is extracted. The
// refined cubes of 16 steps are sampled regularly in octree order, which covers the whole surface,
// and extrapolated to the others. These functions are pure and can run on any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/mesh/octree_cube.hpp"
#include "server/core/fine_errors/prepared_model.hpp"
#include "server/core/surface/tiling.hpp"

namespace multitetra {

// The sampled cubes, and the number of cubes that each one represents.
struct CubeSample {
  static constexpr int kExponent = kSpectrumExponent + 1;

  // Cubes of kExponent.
  std::vector<OctreeCube> cubes;
  double weight = 1;                    // At least 1.
  std::uint64_t coarse_tetrahedra = 0;  // Crossed tetrahedra that belong to larger cubes.
};

// Returns at most `count` cubes, or all if there are no more. Reads no samples. Calls `checkpoint`
// for every visited cube; an exception from it ends the search. Requires a grid of more than
// kSpectrumSpacing steps a side.
[[nodiscard]] CubeSample sample_cubes(
    const PreparedModel& model, std::size_t count, double isovalue,
    const std::function<void()>& checkpoint = [] {});

// Returns the number of tetrahedra of such a cube that the surface crosses.
[[nodiscard]] std::uint64_t crossed_tetrahedra(const PreparedModel& model, const OctreeCube& cube,
                                               double isovalue, CubeMemory& memory);

// Triangles per crossed tetrahedron, which has a triangle or a quad: measured 1.30 to 1.32.
inline constexpr double kTrianglesPerTetrahedron = 1.31;

// Calls `visit` in octree order for the refined cubes of that exponent, which must be at least
// kSpectrumExponent + 1; an exception from it ends the visit. Reads only the spectrum, and takes
// much less time than the other functions here.
void visit_refined_cubes(const PreparedModel& model, int exponent,
                         const std::function<void(const OctreeCube&)>& visit);

}  // namespace multitetra

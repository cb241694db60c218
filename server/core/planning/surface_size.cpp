#include "server/core/planning/surface_size.hpp"

#include <algorithm>

namespace multitetra {
namespace {

OctreeCube root_of(const PreparedModel& model) {
  return {.exponent = model.volume().info.grid_exponent};
}

// Calls visit(cube) for the refined cubes of at least `exponent`, parents before children.
template <typename Visit>
void visit_refined(const PreparedModel& model, const OctreeCube& cube, int exponent,
                   const Visit& visit) {
  if (!is_refined(model, cube)) return;
  visit(cube);
  if (cube.exponent == exponent) return;
  for (int i = 0; i < 8; ++i) visit_refined(model, cube.child(i), exponent, visit);
}

}  // namespace

CubeSample sample_cubes(const PreparedModel& model, std::size_t count, double isovalue,
                        const std::function<void()>& checkpoint) {
  const SurfaceOptions options{.isovalue = isovalue};
  CubeSample sample;
  visit_refined(model, root_of(model), CubeSample::kExponent, [&](const OctreeCube& cube) {
    checkpoint();
    if (cube.exponent == CubeSample::kExponent) {
      sample.cubes.push_back(cube);
    } else {
      sample.coarse_tetrahedra +=
          join_children(model, cube, std::vector<CubeSurface>(8), options).active_tetrahedra;
    }
  });
  const std::size_t all = sample.cubes.size();
  if (all <= count) return sample;
  for (std::size_t i = 0; i < count; ++i)
    sample.cubes[i] = sample.cubes[(2 * i + 1) * all / (2 * count)];
  sample.cubes.resize(count);
  sample.weight = static_cast<double>(all) / static_cast<double>(count);
  return sample;
}

std::uint64_t crossed_tetrahedra(const PreparedModel& model, const OctreeCube& cube,
                                 double isovalue, CubeMemory& memory) {
  return surface_in_cube(model, cube, {.isovalue = isovalue}, memory).active_tetrahedra;
}

void visit_refined_cubes(const PreparedModel& model, int exponent,
                         const std::function<void(const OctreeCube&)>& visit) {
  visit_refined(model, root_of(model), exponent, [&](const OctreeCube& cube) {
    if (cube.exponent == exponent) visit(cube);
  });
}

}  // namespace multitetra

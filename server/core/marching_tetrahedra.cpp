#include "server/core/marching_tetrahedra.hpp"

#include "server/core/field.hpp"

namespace multitetra {

TetrahedronSurface marching_tetrahedron(const std::array<GridPoint, 4>& corners,
                                        const std::array<float, 4>& values, double isovalue,
                                        int resolution) {
  unsigned signs = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (is_void(values[i])) return {};
    if (static_cast<double>(values[i]) > isovalue) signs |= 1U << i;
  }
  if (signs == 0 || signs == 15) return {};
  const bool is_negative = six_volumes(corners[0], corners[1], corners[2], corners[3]) < 0;
  return march(kMarchingCases[signs], is_negative, [&](std::size_t i, std::size_t j) {
    return lattice_vertex(corners[i], static_cast<double>(values[i]), corners[j],
                          static_cast<double>(values[j]), isovalue, resolution);
  });
}

}  // namespace multitetra

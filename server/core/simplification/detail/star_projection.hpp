// A quick proof that the triangles around a vertex do not intersect each other.
#pragma once

#include <span>

#include "common/mesh/lattice.hpp"

namespace multitetra {

// Whether the triangles (centre, around[i], around[i + 1]), cyclic, are seen side by side from some
// direction: all turn the same way, and go once around the centre. Then they have nothing in common
// but the centre and the edges between neighbours. A few directions are tried; false proves
// nothing. Lattice coordinates are within 0 .. 2^kMaxLatticeBits.
[[nodiscard]] bool lie_side_by_side(const LatticePoint& centre,
                                    std::span<const LatticePoint> around);

}  // namespace multitetra

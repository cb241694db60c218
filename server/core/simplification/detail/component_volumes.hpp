// The volumes of a surface's components during edge collapses, which must not turn any inside out.
//
// A closed component has a volume. One that is cut off by planes perpendicular to the axes, at most
// one an axis, as at the border of the data or of a piece, encloses a volume with these planes:
// that of the cones from their common point, since those of the cuts are flat. So a small component
// that lies in two pieces is not turned inside out in either. Other components are not restricted.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"

namespace multitetra {

class ComponentVolumes {
 public:
  // Keeps references to both.
  ComponentVolumes(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices);

  // Returns whether the volume of the component keeps its sign and does not vanish. `ring` are the
  // corners at u, from the target w_0, as in collapsing_mesh.hpp.
  [[nodiscard]] bool keep_sign(std::span<const std::uint32_t> ring) const;
  // Call for every collapse, before CollapsingMesh::collapse.
  void commit(std::span<const std::uint32_t> ring);

 private:
  // Six times a volume in lattice steps, modulo 2^64. A component's is below 2^63, as
  // coordinates are at most 2^20.
  using Volume = std::uint64_t;

  void find_components();
  void find_volumes();
  [[nodiscard]] Volume volume_seen_from(const LatticePoint& origin, std::uint32_t a,
                                        std::uint32_t b, std::uint32_t c) const;
  // Returns the volume that the component loses in the collapse.
  [[nodiscard]] Volume loss(std::span<const std::uint32_t> ring) const;

  const CollapsingMesh& mesh_;
  std::span<const LatticePoint> vertices_;
  // By vertex: one vertex, the same for all vertices of a component.
  std::vector<std::uint32_t> component_of_;
  // By that vertex: the component's volume; 0: not restricted.
  std::vector<Volume> volumes_;
};

}  // namespace multitetra

// Compares a mesh with the isosurface of a volume at full resolution.
//
//   const Volume volume = read_volume("head.nrrd");
//   const Certificate certificate =
//       certify(read_mesh("head.ply"), volume, {.isovalue = 500.5, .error = 0.5});
//   if (!certificate.is_kept()) ...
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "common/mesh/mesh_checks.hpp"
#include "common/request/dataset_info.hpp"
#include "server/certify/self_intersections.hpp"
#include "server/certify/triangle_mesh.hpp"
#include "server/certify/two_sided_distance.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

struct CertifyOptions {
  double isovalue = 0;
  // World units. Without it the distances are measured and nothing is certified.
  std::optional<double> error = std::nullopt;
  // The mesh's vertices may be rounded to a lattice of 2^-lattice grid steps, as ours are: the
  // error is exceeded only beyond that. None: they are where they should be.
  std::optional<int> lattice = std::nullopt;
  bool any_topology = false;  // The topology need not be that of the full surface.
  // Components of the full surface with a shorter bounding-box diagonal, in samples, are not in the
  // mesh on purpose. Those that the error may have moved across this limit may be there or not.
  double min_component = 0;
  bool count_self_intersections = false;
  std::optional<double> outside = std::nullopt;  // The value beyond the data; none means void.
  std::int32_t margin = 0;                       // Grid steps around the data.
  // The number of samples of each surface, for mean and percentile.
  std::uint64_t samples = 200'000;
  // Called at the beginning of each stage: "full surface", "topology", "distances",
  // "self-intersections".
  std::function<void(const char* stage)> on_stage = nullptr;
};

enum class ErrorVerdict {
  kNotAsked,
  kKept,        // Proven: no point of either surface is farther.
  kNotRefuted,  // No point that was looked at is farther, but a bound for all of them is.
  kExceeded,
};

// Components of the full surface that are not in the mesh, although all vertices of the others keep
// the error.
struct MissingComponents {
  std::uint64_t count = 0;
  double largest_diagonal = 0;  // In samples.
  // The least diagonal for `min_component` that expects them to be missing, and no other.
  std::optional<double> min_component;
};

struct Certificate {
  DatasetInfo grid;  // The volume's.
  MeshTopology mesh;
  // The topology of the full-resolution surface.
  MeshTopology reference;
  // Where fans of triangles only touch; at void samples the full surface may have some.
  std::int64_t nonmanifold_vertices = 0;
  std::int64_t nonmanifold_vertices_of_reference = 0;
  // Triangles of the mesh with two corners at one place; they are left out.
  std::uint64_t degenerate_triangles = 0;
  // Vertices of the mesh where the volume has no samples around them.
  std::uint64_t vertices_beyond_data = 0;
  TwoSidedDistance distance;  // World units.
  // Tolerance for the lattice and for 32-bit coordinates, world units.
  double lattice_allowance = 0;
  double rounding_allowance = 0;
  ErrorVerdict error = ErrorVerdict::kNotAsked;
  bool is_topology_asked = true;
  std::optional<MissingComponents>
      missing;  // Set where the mesh is not kept for this reason alone.
  std::optional<SelfIntersections> self_intersections;

  [[nodiscard]] double maximum() const;          // The larger one of both directions.
  [[nodiscard]] double maximum_at_most() const;  // Likewise.
  // No edge has fewer or more than two triangles, or two that face different sides.
  [[nodiscard]] bool is_watertight() const;
  // As many components, holes and handles as the full surface, and open only where the data end or
  // void samples are.
  [[nodiscard]] bool keeps_topology() const;
  [[nodiscard]] bool is_kept() const;
};

// The largest displacement of a vertex by rounding, in world units: one step along the longest
// diagonal of a grid cell.
[[nodiscard]] double lattice_step_world(const DatasetInfo& grid, int lattice);

// `mesh` is in the volume's world coordinates. On all threads that oneTBB may use. Throws
// std::invalid_argument when the volume does not fit the largest grid.
[[nodiscard]] Certificate certify(const TriangleMesh& mesh, const Volume& volume,
                                  const CertifyOptions& options);

}  // namespace multitetra

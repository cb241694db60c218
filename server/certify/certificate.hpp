// Compares a mesh with the isosurface of a volume at full resolution.
//
//   const Volume volume = read_volume("head.nrrd");
//   const Certificate certificate =
//       certify(read_mesh("head.ply"), volume, {.isovalue = 500.5, .error = 0.5});
//   if (!certificate.passes()) ...
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/self_intersections.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/clipped_mesh.hpp"
#include "server/certify/two_sided_distance.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

struct CertifyOptions {
  double isovalue = 0;
  // World units. If absent, distances are measured but not certified.
  std::optional<double> error = std::nullopt;
  // Allows for vertices rounded to a lattice of 2^-lattice grid steps, as ours are: the error is
  // exceeded only beyond the rounding. If absent, vertices are taken as exact.
  std::optional<int> lattice = std::nullopt;
  bool any_topology = false;  // Accepts any topology.
  // Components of the full surface with a shorter bounding-box diagonal, in samples, are expected
  // to be missing. Those that the error may have moved across this limit may be present or missing.
  double min_component = 0;
  bool count_self_intersections = false;
  // Compares only what is inside this box, and the topology nowhere.
  std::optional<PlacedBox> within = std::nullopt;
  // The value beyond the data; absent means void.
  std::optional<double> outside = std::nullopt;
  // Grid steps around the data.
  std::int32_t margin = 0;
  // Also allows for the rounding of 32-bit coordinates in the mesh.
  bool allow_rounding = false;
  // Triangles of the mesh face high values, as those of some programs do.
  bool is_inside_out = false;
  // Looks for a usual map, such as from metres to millimetres, with which a mesh that is too far
  // away would fit.
  bool try_maps = false;
  // Number of samples per surface for mean and percentile.
  std::uint64_t samples = 200'000;
  // Called at the start of each stage: "full surface", "topology", "distances",
  // "self-intersections".
  std::function<void(const char* stage)> on_stage = nullptr;
  std::stop_token stop = {};
};

enum class ErrorVerdict {
  kNotRequested,
  kProven,     // Proven: no point of either surface is farther.
  kUndecided,  // No measured point is farther, but the upper bound exceeds the error.
  kExceeded,
};

// Components of the full surface that the mesh lacks; all other vertices are within the error.
struct MissingComponents {
  std::uint64_t count = 0;
  double largest_diagonal = 0;  // In samples.
  // The least `min_component` with which exactly these components are expected to be missing.
  std::optional<double> min_component;
};

// Components without open edges, by the sides that their triangles face. Components whose volume is
// within the rounding error are not counted.
struct ClosedComponents {
  std::int64_t outwards = 0;  // Enclose high values.
  std::int64_t inwards = 0;   // Enclose low values: cavities.

  friend bool operator==(const ClosedComponents&, const ClosedComponents&) = default;
};

// Components of the mesh that differ from those of the full surface although distances and totals
// agree.
struct ComponentFaults {
  std::uint64_t reversed = 0;      // Their triangles face the other side.
  bool are_all_reversed = false;   // These are all components of the mesh.
  std::uint64_t misplaced = 0;     // They lie on another side of a large component.
  std::optional<Vec3> place = {};  // On the first of them.

  [[nodiscard]] bool is_none() const { return reversed == 0 && misplaced == 0; }
};

// Components of the full surface that `min_component` leaves out of the comparison although their
// diagonal is not below it: the allowed error may have moved them across the limit.
struct LeftOutComponents {
  std::uint64_t count = 0;
  double largest_diagonal = 0;  // In samples.
};

// A map of the mesh's coordinates, as an option of the command, with which the measured distance of
// its vertices is small.
struct MapSuggestion {
  std::string option;
  double distance = 0;  // World units.
};

struct Certificate {
  DatasetInfo grid;  // Describes the volume.
  MeshTopology mesh;
  // Topology of the full-resolution surface.
  MeshTopology reference;
  ClosedComponents closed;
  ClosedComponents closed_of_reference;
  // Vertices where fans of triangles only touch; the full surface may have some at void samples.
  std::int64_t nonmanifold_vertices = 0;
  std::int64_t nonmanifold_vertices_of_reference = 0;
  // Triangles of the mesh with two coincident corners; they are ignored.
  std::uint64_t degenerate_triangles = 0;
  // Vertices of the mesh in places without samples around them.
  std::uint64_t vertices_beyond_data = 0;
  TwoSidedDistance distance;  // In world units.
  // What is allowed for vertices on the lattice, in world units.
  double lattice_allowance = 0;
  // The largest displacement of a vertex by rounding to 32 bits, if the mesh's coordinates are such
  // numbers; allowed only if the options say so.
  double rounding = 0;
  double rounding_allowance = 0;
  ErrorVerdict error = ErrorVerdict::kNotRequested;
  // Whether the mesh must have the topology of the full surface.
  bool is_topology_required = true;
  ComponentFaults faults = {};
  LeftOutComponents left_out = {};
  std::optional<MapSuggestion> suggestion;
  // Set if missing components are the only reason for failure.
  std::optional<MissingComponents> missing;
  std::optional<SelfIntersections> self_intersections;

  // Returns the larger of the largest distances measured in both directions, in world units.
  [[nodiscard]] double maximum() const;
  // Returns the larger of the upper bounds of both directions, in world units.
  [[nodiscard]] double maximum_at_most() const;
  // Returns whether every edge has exactly two triangles, with consistent orientation.
  [[nodiscard]] bool is_watertight() const;
  // Returns whether the mesh has as many components, holes and handles as the full surface, and is
  // open only where the data end or at void samples.
  [[nodiscard]] bool keeps_topology() const;
  // Returns whether every component faces the side that its counterpart in the full surface faces,
  // and lies inside the same components. Known only if the topology is kept and required.
  [[nodiscard]] bool keeps_components() const { return faults.is_none(); }
  // Returns whether no point was found beyond the error and, if required, topology and components
  // are kept.
  [[nodiscard]] bool passes() const;
};

// Compares `mesh`, in the volume's world coordinates, with the volume, on all threads of oneTBB.
// Throws Cancelled after the options' `stop` is triggered, soon while distances are searched for,
// and std::invalid_argument if the volume exceeds the largest grid, or neither surface has a part
// within the box.
[[nodiscard]] Certificate certify(const TriangleMesh& mesh, const Volume& volume,
                                  const CertifyOptions& options);

}  // namespace multitetra

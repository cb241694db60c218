// A request for an isosurface: the isovalue, the allowed error at every place, and the guarantees.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/result.hpp"
#include "common/mesh/lattice.hpp"
#include "common/request/local_thresholds.hpp"
#include "common/request/surface_cell.hpp"

namespace multitetra {

// The error of a dividing point that is compared with the threshold.
enum class ErrorMeasure {
  kCertified,  // Bounds the two-sided Hausdorff distance to the full-resolution surface.
  kPaper,      // The error of Zhou, Chen and Kaufman 1997; the real distance may exceed it.
};

// The changes of sign at a dividing point that prevent its fusion.
enum class TopologyRule {
  kExact,  // Those that change the topology of the isosurface.
  kPaper,  // All of them (Zhou, Chen and Kaufman 1997).
};

enum class ErrorUnit {
  kVoxel,  // 1 is the smallest spacing of the dataset.
  kWorld,  // The unit of the dataset's spacing.
};

[[nodiscard]] std::string_view name(ErrorMeasure measure);  // "certified", "paper"
[[nodiscard]] std::string_view name(TopologyRule rule);     // "exact", "paper"
[[nodiscard]] std::string_view name(ErrorUnit unit);        // "voxel", "world"
[[nodiscard]] std::optional<ErrorMeasure> error_measure_from(std::string_view name);
[[nodiscard]] std::optional<TopologyRule> topology_rule_from(std::string_view name);
[[nodiscard]] std::optional<ErrorUnit> error_unit_from(std::string_view name);

inline constexpr int kMinNormalBits = 8;
inline constexpr int kMaxNormalBits = 10;

struct IsosurfaceRequest {
  // Finite. Outside the data's range the mesh is empty, without an error.
  double isovalue = 0;
  // The threshold where `thresholds` define none, >= 0 and finite, in `unit`. 0 gives the
  // full-resolution surface. Programs, HTTP and messages default to kDefaultError instead.
  double error = 1;
  // The unit of all thresholds.
  ErrorUnit unit = ErrorUnit::kVoxel;
  ErrorMeasure error_measure = ErrorMeasure::kCertified;
  TopologyRule topology_rule = TopologyRule::kExact;
  // In voxels, >= 0. Features up to this spacing may vanish; 0 preserves the topology.
  double topology_tolerance = 0;
  // r, from kMinLatticeResolution to kMaxLatticeResolution.
  int lattice_resolution = kDefaultLatticeResolution;
  // Allowed errors that differ from `error` in some places.
  LocalThresholds thresholds = {};
  // A budget: the maximum triangles and payload bytes of the final step; 0: no limit.
  std::uint64_t max_triangles = 0;
  std::uint64_t max_bytes = 0;
  // Removes triangles that the error does not require: see server/core/simplification.
  bool simplify = false;
  // With `simplify`: meshes have no self-intersections; takes two to three times as long.
  bool intersection_free = false;
  // Bits per octahedral coordinate of normals, 8 to 10; 0: no normals.
  int normal_bits = 0;
  // Restricts the surface to this cell, in one step. Absent: the whole surface. Excludes a budget.
  std::optional<OctreeNode> cell = std::nullopt;

  friend bool operator==(const IsosurfaceRequest&, const IsosurfaceRequest&) = default;
};

[[nodiscard]] inline bool has_budget(const IsosurfaceRequest& request) {
  return request.max_triangles > 0 || request.max_bytes > 0;
}

// Returns the request. Fails if a field is out of its documented range, naming the field, its value
// and the range: with kLimitExceeded for excessive counts, otherwise with kInvalidArgument.
[[nodiscard]] Result<IsosurfaceRequest> validated(const IsosurfaceRequest& request);

}  // namespace multitetra

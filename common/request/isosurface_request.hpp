// A request for a surface: an isovalue, the allowed error at every place, and the guarantees.
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
  kCertified,  // Bounds the two-sided distance between the mesh and the full-resolution isosurface.
  kPaper,      // The error of Zhou, Chen and Kaufman 1997; the real distance may exceed it.
};

// The changes of sign at a dividing point that forbid its fusion.
enum class TopologyRule {
  kExact,  // Those that change the topology of the isosurface.
  kPaper,  // All of them (Zhou, Chen and Kaufman 1997).
};

enum class LengthUnit {
  kVoxel,  // 1 is the dataset's smallest spacing.
  kWorld,  // The unit of the dataset's spacing.
};

[[nodiscard]] std::string_view name(ErrorMeasure measure);  // "certified", "paper"
[[nodiscard]] std::string_view name(TopologyRule rule);     // "exact", "paper"
[[nodiscard]] std::string_view name(LengthUnit unit);       // "voxel", "world"
[[nodiscard]] std::optional<ErrorMeasure> error_measure_from(std::string_view name);
[[nodiscard]] std::optional<TopologyRule> topology_rule_from(std::string_view name);
[[nodiscard]] std::optional<LengthUnit> length_unit_from(std::string_view name);

inline constexpr int kMinNormalBits = 8;
inline constexpr int kMaxNormalBits = 10;

struct IsosurfaceRequest {
  double isovalue = 0;  // Finite. Outside the data's range the mesh is empty; that is no error.
  // The threshold where `thresholds` say nothing else, >= 0 and finite, in `unit`. 0 is the
  // full-resolution surface.
  double error = 1;
  // The unit of all thresholds.
  LengthUnit unit = LengthUnit::kVoxel;
  ErrorMeasure measure = ErrorMeasure::kCertified;
  TopologyRule topology_rule = TopologyRule::kExact;
  double topology_tolerance =
      0;  // >= 0, voxels. Features up to this spacing may vanish; 0 preserves the topology.
  int lattice_resolution =
      kDefaultLatticeResolution;    // r, kMinLatticeResolution to kMaxLatticeResolution.
  LocalThresholds thresholds = {};  // Allowed errors that differ from `error` in some places.
  // A budget: the largest mesh and the most payload bytes that the final step may have; 0: as large
  // as the thresholds make it.
  std::uint64_t max_triangles = 0;
  std::uint64_t max_bytes = 0;
  // Whether meshes get rid of triangles that the error does not need: see
  // server/core/simplification.
  bool simplify = false;
  // With `simplify`: whether meshes may nowhere cut themselves; two to three times as long.
  bool embedded = false;
  // The bits of each of a normal's two octahedral coordinates, 8 to 10; 0: no normals.
  int normal_bits = 0;
  // Only what lies in this cell; it comes in one step. None: everything. Goes with no budget.
  std::optional<SurfaceCell> cell = std::nullopt;

  friend bool operator==(const IsosurfaceRequest&, const IsosurfaceRequest&) = default;
};

// kInvalidArgument, or kLimitExceeded where there is too much of something, naming the field, its
// value and the range, unless every field is within its documented range.
[[nodiscard]] Result<IsosurfaceRequest> validated(const IsosurfaceRequest& request);

}  // namespace multitetra

// The strongest check of a fetched surface: its distance to the full-resolution surface of a local
// copy of the volume, both ways, against what the request promises.
//
//   const DistanceCheck check = check_distances(step, info, samples, {});
//   if (!check.has_passed()) ...
//
// Points are sampled by area from each surface and their distances to the other one are taken
// exactly (surface_distance.hpp). So a violation that is found is one; a sampled maximum may be
// below the true one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "client/library/assembler.hpp"
#include "common/mesh/surface_distance.hpp"
#include "common/request/dataset_info.hpp"

namespace multitetra {

struct DistanceCheckOptions {
  std::size_t samples = 20'000;  // Each way.
  std::uint64_t seed = 1;
};

// Lengths in voxels (of the smallest spacing), places in world coordinates.
struct DistanceCheck {
  std::uint64_t full_triangles = 0;
  DistanceStatistics mesh_to_full;
  DistanceStatistics full_to_mesh;
  // The threshold and how far the lattice may move a vertex; their sum is the limit. None when
  // nothing is promised: the bound is not certified, or the topology may change.
  struct Promise {
    double threshold = 0;
    double snapping = 0;
  };
  std::optional<Promise> promise;

  [[nodiscard]] bool has_passed() const {
    return !promise || (mesh_to_full.above_limit == 0 && full_to_mesh.above_limit == 0);
  }
};

// How far a vertex may be from its exact place on its edge, in world units: less than one lattice
// step along the longest diagonal of a grid cell.
[[nodiscard]] double snapping_world(const DatasetInfo& info, int lattice_resolution);

// What a step promises at each place, in world units: none where it promises nothing.
[[nodiscard]] std::optional<DistanceLimit> promised_limit(const StepBegin& begin,
                                                          const DatasetInfo& info);

// Requires samples of the dataset, see read_local_volume.
[[nodiscard]] DistanceCheck check_distances(const CommittedStep& step, const DatasetInfo& info,
                                            std::span<const float> samples,
                                            const DistanceCheckOptions& options);

}  // namespace multitetra

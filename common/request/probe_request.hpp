// A request for the field at given places, and its reply.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/base/result.hpp"
#include "common/base/vec3.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxProbedPlaces = 1024;

struct ProbeRequest {
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  std::vector<Vec3> places = {};  // 1 to kMaxProbedPlaces; within +-kMaxCoordinate.

  friend bool operator==(const ProbeRequest&, const ProbeRequest&) = default;
};

// Returns the request, or kInvalidArgument or kLimitExceeded, naming the place out of range.
[[nodiscard]] Result<ProbeRequest> validated(const ProbeRequest& probe);

struct ProbedPlace {
  Vec3 world = {0, 0, 0};
  Vec3 index = {0, 0, 0};            // In sample indices.
  std::optional<double> value = {};  // Trilinear, in sample values; absent where there is no field.
  std::optional<Vec3> gradient = {};  // In sample values per world unit; present with a value.

  friend bool operator==(const ProbedPlace&, const ProbedPlace&) = default;
};

}  // namespace multitetra

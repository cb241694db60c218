#include "common/request/probe_request.hpp"

#include <cmath>
#include <string>

namespace multitetra {

Result<ProbeRequest> validated(const ProbeRequest& probe) {
  if (probe.places.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "Probe.places is empty; it must have one place or more.");
  }
  if (probe.places.size() > kMaxProbedPlaces) {
    return fail(ErrorCode::kLimitExceeded,
                "Probe.places has " + std::to_string(probe.places.size()) + " places; at most " +
                    std::to_string(kMaxProbedPlaces) + " are allowed.");
  }
  for (std::size_t i = 0; i < probe.places.size(); ++i) {
    for (const double coordinate : probe.places[i]) {
      if (std::abs(coordinate) <= kMaxCoordinate) continue;
      return fail(ErrorCode::kInvalidArgument,
                  "Place " + std::to_string(i) +
                      " of the probe has a coordinate that is not a number from -1e100 to 1e100.");
    }
  }
  return probe;
}

}  // namespace multitetra

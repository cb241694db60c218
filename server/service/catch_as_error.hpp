// Runs functions that may throw, and returns exceptions as errors.
#pragma once

#include <stop_token>
#include <string>

#include "common/base/in_parallel.hpp"
#include "common/base/result.hpp"

namespace multitetra {

// Returns the error for clients when `what` of the dataset failed with the exception being handled.
// Requires a handler. Logs failures that the request did not cause.
[[nodiscard]] Error error_of_exception(const std::string& what, const std::string& dataset);

// Returns the result of `make`, or an error if it throws; kCancelled if `stop` is set.
template <typename Make>
[[nodiscard]] auto catch_as_error(const std::string& what, const std::string& dataset,
                                  const std::stop_token& stop, const Make& make)
    -> decltype(make()) {
  try {
    if (stop.stop_requested()) throw Cancelled{};
    return make();
  } catch (...) {
    return tl::unexpected(error_of_exception(what, dataset));
  }
}

}  // namespace multitetra

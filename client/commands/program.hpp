// Shared by the commands of multitetra-client: failures and exit codes.
#pragma once

#include <string>
#include <utility>

#include "client/library/client.hpp"
#include "common/base/exit_codes.hpp"

namespace multitetra {

inline const std::string kProgram = "multitetra-client";

inline const std::string kExitCodes =
    "Exit codes: 0 done, 1 failed (network, server, file), 2 wrong usage, 3 a check failed,\n"
    "6 the surface is empty.";

// Throws the ExitError of a failure.
[[noreturn]] inline void exit_with(const ClientError& failure) {
  const std::string prefix = failure.source == ErrorSource::kServer  ? "server: "
                             : failure.source == ErrorSource::kCheck ? "a check failed: "
                                                                     : "";
  throw ExitError(failure.source == ErrorSource::kCheck ? kCheckFailed : kFailed,
                  prefix + failure.error.text);
}

// Returns the value of an option's part. Throws ExitError (kUsage) for invalid ones.
template <typename T>
[[nodiscard]] T value_or_usage_error(Result<T> value) {
  if (!value) throw ExitError(kUsage, value.error().text);
  return *std::move(value);
}

}  // namespace multitetra

// Shared by the commands of multitetra-client: error output and exit codes.
#pragma once

#include <string>

#include "client/library/client.hpp"
#include "common/base/exit_codes.hpp"
#include "common/cli/program.hpp"

namespace multitetra {

inline const std::string kProgram = "multitetra-client";

inline const std::string kExitCodes =
    "Exit codes: 0 done, 1 failed (network, server, file), 2 wrong usage, 3 a check failed,\n"
    "6 the surface is empty.";

inline ExitCode print_error(ExitCode code, const std::string& text) {
  print_error(kProgram, text);
  return code;
}

inline ExitCode print_error(const ClientError& failure) {
  const std::string prefix = failure.source == ErrorSource::kServer  ? "server: "
                             : failure.source == ErrorSource::kCheck ? "a check failed: "
                                                                     : "";
  return print_error(failure.source == ErrorSource::kCheck ? kCheckFailed : kFailed,
                     prefix + failure.error.text);
}

}  // namespace multitetra

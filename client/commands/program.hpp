// What the commands of multitetra-client share: how they complain, and end.
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

inline ExitCode complain(ExitCode code, const std::string& text) {
  complain(kProgram, text);
  return code;
}

inline ExitCode complain(const ClientError& trouble) {
  const std::string prefix = trouble.trouble == Trouble::kServer  ? "server: "
                             : trouble.trouble == Trouble::kCheck ? "a check failed: "
                                                                  : "";
  return complain(trouble.trouble == Trouble::kCheck ? kCheckFailed : kFailed,
                  prefix + trouble.error.text);
}

}  // namespace multitetra

// Runs `info` or `verify` on each dataset of a folder.
#pragma once

#include <exception>
#include <string>

#include "common/base/exit_codes.hpp"
#include "common/cli/program.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {

// Calls work(place) for each dataset. Prints a failure, passes it to failed(place, problem), and
// continues. Throws ExitError (kUsage) if there are no datasets.
template <typename Work, typename Failed>
[[nodiscard]] ExitCode with_each_dataset(const std::string& folder, const Work& work,
                                         const Failed& failed) {
  const auto datasets = datasets_in(folder);
  if (datasets.empty()) throw ExitError(kUsage, "There is no dataset in " + folder + ".");
  ExitCode code = kOk;
  for (const std::string& dataset : datasets) {
    try {
      work(dataset);
    } catch (const std::exception& problem) {
      code = kFailed;
      print_error("multitetra-server", problem.what());
      failed(dataset, problem.what());
    }
  }
  return code;
}

}  // namespace multitetra

// Runs `info` or `verify` for each dataset of a folder.
#pragma once

#include <exception>
#include <string>

#include "common/base/exit_codes.hpp"
#include "common/cli/program.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {

// Calls work(place) with each. A failure is printed and passed to failed(place, problem); the
// others are processed all the same. Throws ExitError (kUsage) when there is none.
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

// The files that a command will write, looked at before its work begins.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace multitetra {

// A file and the option that names it. Those without a name are passed over.
struct NamedFile {
  std::string option;
  std::filesystem::path file;
};

// Throws ExitError (kUsage) when an output is one of the inputs, under whatever name, or there are
// two of one name; std::system_error when one cannot be written. What earlier runs have left of it
// that were killed is removed.
void require_outputs(const std::vector<NamedFile>& outputs,
                     const std::vector<NamedFile>& inputs = {});

}  // namespace multitetra

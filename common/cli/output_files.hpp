// Checks the files that a command will write before its work begins.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace multitetra {

// A file and the option that names it. Entries with an empty file are ignored.
struct NamedFile {
  std::string option;
  std::filesystem::path file;
};

// Throws ExitError (kUsage) if an output is also an input, under any name, or two outputs are the
// same file; std::system_error if an output cannot be written. Removes temporary files of killed
// runs.
void require_outputs(const std::vector<NamedFile>& outputs,
                     const std::vector<NamedFile>& inputs = {});

// Returns the file of one of several surfaces: organs_liver.ply for organs.ply and liver.
[[nodiscard]] std::filesystem::path file_of_part(const std::filesystem::path& output,
                                                 const std::string& part);

}  // namespace multitetra

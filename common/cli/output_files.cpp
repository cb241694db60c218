#include "common/cli/output_files.hpp"

#include <system_error>

#include "common/base/atomic_file.hpp"
#include "common/base/exit_codes.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Returns whether both names denote the same file, which need not exist.
bool are_same(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  return fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error) && !error;
}

}  // namespace

fs::path file_of_part(const fs::path& output, const std::string& part) {
  return output.parent_path() / (output.stem().string() + "_" + part + output.extension().string());
}

void require_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto& [option, file] = outputs[i];
    if (file.empty()) continue;
    for (const NamedFile& input : inputs) {
      if (input.file.empty() || !are_same(file, input.file)) continue;
      throw ExitError(kUsage, option + ": " + file.string() + " is also the file of " +
                                  input.option + " and would be overwritten; choose another name.");
    }
    for (std::size_t other = 0; other < i; ++other) {
      if (outputs[other].file.empty() || !are_same(file, outputs[other].file)) continue;
      throw ExitError(kUsage, option + ": " + file.string() + " is also written by " +
                                  outputs[other].option + "; choose another name.");
    }
    require_writable(file);
  }
}

}  // namespace multitetra

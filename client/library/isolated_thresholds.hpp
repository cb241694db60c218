// Reads threshold images in a sandboxed process, as files from elsewhere are untrusted.
#pragma once

#include <filesystem>

#include "common/base/result.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// Returns what read_nrrd_thresholds() returns, for check by validated(); kDamagedData if that
// crashes, hangs or takes too much memory. The reader sees the file and its folder. Requires
// enter_sandbox_if_asked() in main().
[[nodiscard]] Result<ThresholdGrid> read_thresholds_isolated(const std::filesystem::path& file,
                                                             double elsewhere,
                                                             const std::string& length_unit);

}  // namespace multitetra

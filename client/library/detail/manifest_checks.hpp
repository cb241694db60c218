// Checks of a StepBegin before a client allocates anything for it.
#pragma once

#include <optional>
#include <string>

#include "client/library/stream_validator.hpp"

namespace multitetra {

// A failed check of a step: "Step 2: WHAT."
[[nodiscard]] tl::unexpected<Error> step_fault(std::uint32_t step, const std::string& what);
// For error texts: "tile 3 (cube 5:3/0/7)".
[[nodiscard]] std::string tile_name(const StepBegin& begin, std::size_t index);

// The contradiction to the request, the dataset or the limits, as one sentence; nullopt when
// nothing does.
[[nodiscard]] std::optional<std::string> manifest_fault(const StepBegin& begin,
                                                        const OpenStream& open,
                                                        const DatasetInfo& info,
                                                        const AssemblerLimits& limits);

// What of the totals is above the limits, as the end of a sentence; nullopt when nothing is.
[[nodiscard]] std::optional<std::string> excess(const ManifestTotals& totals,
                                                const AssemblerLimits& limits);

}  // namespace multitetra

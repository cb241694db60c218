// Checks of a StepBegin before a client allocates anything for it.
#pragma once

#include <optional>
#include <string>

#include "client/library/stream_validator.hpp"

namespace multitetra {

// Returns a failed check of a step: "Step 2: WHAT."
[[nodiscard]] tl::unexpected<Error> step_fault(std::uint32_t step, const std::string& what);
// Returns "tile 3 (cube 5:3/0/7)", for error texts.
[[nodiscard]] std::string tile_name(const StepBegin& begin, std::size_t index);

// Returns in one sentence how the manifest contradicts the request, the dataset or the limits;
// nullopt if it is valid.
[[nodiscard]] std::optional<std::string> manifest_fault(const StepBegin& begin,
                                                        const OpenStream& open,
                                                        const DatasetInfo& info,
                                                        const AssemblerLimits& limits);

// Returns the totals that exceed the limits, as the end of a sentence; nullopt if none does.
[[nodiscard]] std::optional<std::string> exceeded_limits(const ManifestTotals& totals,
                                                         const AssemblerLimits& limits);

}  // namespace multitetra

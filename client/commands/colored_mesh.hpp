// The accuracy of surfaces colored by a field.
#pragma once

#include <string>

#include "client/library/assembler.hpp"

namespace multitetra {

// Returns "Colors between vertices may be off by up to 0.12, those of vertices by 0.01."; empty
// without scalars.
[[nodiscard]] std::string accuracy_text(const CommittedStep& step);

}  // namespace multitetra

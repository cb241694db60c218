// A fetched surface on its way to a file or a picture.
#pragma once

#include <optional>

#include "client/library/assembler.hpp"
#include "common/cli/surface_output.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

// Makes the output of a final step, with its report and notices. Prints the accuracy of colors
// unless `output` is quiet.
void finish(OutputPart& part, const CommittedStep& step,
            const std::optional<ScalarRequest>& scalars, const SurfaceArguments& arguments,
            const OutputArguments& output);

}  // namespace multitetra

// Creates a shell's header from its options, and encodes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/codec/shell_encoder.hpp"
#include "common/codec/shell_format.hpp"

namespace multitetra::shell {

[[nodiscard]] inline tl::unexpected<Error> not_encodable(std::string why) {
  return fail(ErrorCode::kInvalidArgument, std::move(why));
}

// Sets everything that does not depend on the samples. Fails with kInvalidArgument for input the
// format cannot represent.
[[nodiscard]] Result<ShellHeader> header_for(const ShellBox& box, const ShellOptions& options);

[[nodiscard]] std::vector<std::uint8_t> written_header(const ShellHeader& header,
                                                       std::size_t raw_size);

}  // namespace multitetra::shell

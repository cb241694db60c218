// Converts payload codecs and steps of sample shells to and from wire messages.
#pragma once

#include <vector>

#include "common/wire/detail/wire_checks.hpp"
#include "common/wire/messages.hpp"
#include "multitetra/v1/conversation.pb.h"

namespace multitetra::wire {

// Returns the known codecs and ignores others.
[[nodiscard]] std::vector<PayloadCodec> known_codecs(
    const google::protobuf::RepeatedField<int>& wire);
[[nodiscard]] bool has_draco(const std::vector<PayloadCodec>& codecs);

void write_shell_step(const ShellStep& step, v1::ShellStep& wire);
[[nodiscard]] ShellStep read_shell_step(std::string_view field, const v1::ShellStep& wire,
                                        FieldChecks& checks);

}  // namespace multitetra::wire

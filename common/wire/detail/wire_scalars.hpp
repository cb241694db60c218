// Converts scalars to and from wire messages.
#pragma once

#include "common/wire/detail/wire_checks.hpp"
#include "common/wire/messages.hpp"
#include "multitetra/v1/conversation.pb.h"

namespace multitetra::wire {

void write(const ScalarRequest& request, v1::ScalarRequest& wire);
[[nodiscard]] ScalarRequest read(const v1::ScalarRequest& wire, FieldChecks& checks);

void write(const ScalarRange& range, v1::ScalarRange& wire);
[[nodiscard]] ScalarRange read(const v1::ScalarRange& wire, FieldChecks& checks);

void write(const TileScalars& scalars, v1::TileScalars& wire);
// Moves the codes out of the message.
[[nodiscard]] TileScalars read(v1::TileScalars& wire, FieldChecks& checks);

}  // namespace multitetra::wire

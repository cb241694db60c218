// Converts slices and probes to and from wire messages.
#pragma once

#include "common/wire/detail/wire_checks.hpp"
#include "common/wire/messages.hpp"
#include "multitetra/v1/conversation.pb.h"

namespace multitetra::wire {

void write(const Slice& slice, v1::Slice& wire);
[[nodiscard]] Slice read(const v1::Slice& wire, FieldChecks& checks);

void write(const Probe& probe, v1::Probe& wire);
[[nodiscard]] Probe read(const v1::Probe& wire, FieldChecks& checks);

void write(const SliceReply& reply, v1::SliceReply& wire);
// Moves the values out of the message.
[[nodiscard]] SliceReply read(v1::SliceReply& wire, FieldChecks& checks);

void write(const ProbeReply& reply, v1::ProbeReply& wire);
[[nodiscard]] ProbeReply read(const v1::ProbeReply& wire, FieldChecks& checks);

}  // namespace multitetra::wire

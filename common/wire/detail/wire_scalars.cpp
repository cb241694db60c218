#include "common/wire/detail/wire_scalars.hpp"

#include <utility>

namespace multitetra::wire {

void write(const ScalarRequest& request, v1::ScalarRequest& wire) {
  wire.set_dataset(request.dataset);
  wire.set_bits(static_cast<std::uint32_t>(request.bits));
  wire.set_in_any_world(request.in_any_world);
  if (!request.limits) return;
  wire.set_low(request.limits->low);
  wire.set_high(request.limits->high);
}

ScalarRequest read(const v1::ScalarRequest& wire, FieldChecks& checks) {
  checks.dataset_name("ScalarRequest.dataset", wire.dataset());
  checks.require(wire.has_low() == wire.has_high(), "ScalarRequest.low",
                 "and high must be given together.");
  ScalarRequest request{.dataset = wire.dataset(), .in_any_world = wire.in_any_world()};
  // Larger numbers are out of range in any case.
  if (wire.bits() != 0) request.bits = static_cast<int>(std::min<std::uint32_t>(wire.bits(), 1000));
  if (wire.has_low()) request.limits = ScalarRequest::Limits{wire.low(), wire.high()};
  checks.valid(validated(request));
  return request;
}

void write(const ScalarRange& range, v1::ScalarRange& wire) {
  wire.set_low(range.low);
  wire.set_high(range.high);
  wire.set_bits(static_cast<std::uint32_t>(range.bits));
}

ScalarRange read(const v1::ScalarRange& wire, FieldChecks& checks) {
  checks.finite("ScalarRange.low", wire.low());
  checks.finite("ScalarRange.high", wire.high());
  checks.require(wire.low() <= wire.high(), "ScalarRange.high", "must not be below low.");
  checks.require(wire.bits() == 8 || wire.bits() == 16, "ScalarRange.bits", "must be 8 or 16.");
  return {.low = wire.low(), .high = wire.high(), .bits = wire.bits() == 8 ? 8 : 16};
}

void write(const TileScalars& scalars, v1::TileScalars& wire) {
  wire.set_request_id(scalars.request_id);
  wire.set_step(scalars.step);
  wire.set_index(scalars.index);
  wire.set_codes(*scalars.codes);
  wire.set_largest_deviation(scalars.largest_deviation);
}

TileScalars read(v1::TileScalars& wire, FieldChecks& checks) {
  checks.integer("TileScalars.request_id", wire.request_id(), 1);
  checks.require(!wire.codes().empty(), "TileScalars.codes", "must have at least one code.");
  checks.not_negative("TileScalars.largest_deviation", wire.largest_deviation());
  return {.request_id = wire.request_id(),
          .step = wire.step(),
          .index = wire.index(),
          .codes = std::make_shared<const std::string>(std::move(*wire.mutable_codes())),
          .largest_deviation = wire.largest_deviation()};
}

}  // namespace multitetra::wire

#include "common/wire/detail/wire_codecs.hpp"

#include <algorithm>
#include <string>

namespace multitetra::wire {

std::vector<PayloadCodec> known_codecs(const google::protobuf::RepeatedField<int>& wire) {
  std::vector<PayloadCodec> known;
  for (const PayloadCodec codec : {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell}) {
    if (std::count(wire.begin(), wire.end(), static_cast<int>(codec)) > 0) known.push_back(codec);
  }
  return known;
}

bool has_draco(const std::vector<PayloadCodec>& codecs) {
  return std::count(codecs.begin(), codecs.end(), PayloadCodec::kDracoLattice) > 0;
}

void write_shell_step(const ShellStep& step, v1::ShellStep& wire) {
  wire.set_values(to_wire<v1::ShellValues>(step.values));
  wire.set_levels_per_octave(static_cast<std::uint32_t>(step.levels_per_octave));
}

ShellStep read_shell_step(std::string_view field, const v1::ShellStep& wire, FieldChecks& checks) {
  const std::string name(field);
  const ShellStep step = {.values = checks.enumerator<shell::ShellValues>(
                              name + ".values", wire.values(), shell::ShellValues::kQuantized, {}),
                          // Larger numbers are out of range in any case.
                          .levels_per_octave = static_cast<int>(
                              std::min<std::uint32_t>(wire.levels_per_octave(), 1000))};
  checks.require(is_possible(step), name + ".levels_per_octave",
                 "must be 1, 2, 4 or 8 for quantized values, and 0 otherwise.");
  return step;
}

}  // namespace multitetra::wire

#include "common/codec/detail/shell_model.hpp"

#include "common/codec/detail/trained_tables.hpp"

namespace multitetra::shell {

namespace {

// A model consists only of its probabilities, in the order of its members.
template <typename Model, size_t kCount>
void start_from(const uint8_t (&trained)[kCount], Model& model) {
  static_assert(sizeof(Model) == kCount * sizeof(Probability));
  auto* probability = reinterpret_cast<Probability*>(&model);
  for (const uint8_t byte : trained) {
    const auto start = static_cast<uint16_t>(128 * byte + 64);
    *probability++ = {.fast = start, .slow = start};
  }
}

}  // namespace

void ShellModel::begin(ShellValues kind) {
  start_from(kTrainedSigns, presence);
  start_from(kTrainedSigns, signs);
  start_from(kind == ShellValues::kExact ? kTrainedExactValues : kTrainedLevels, values);
  start_from(kTrainedCorrections, corrections);
}

}  // namespace multitetra::shell

// The name of a preview within its stream: where the model's hierarchy ends, and whether its
// surface is simplified or comes in sample shells. Everything else follows from the request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/request/shell_step.hpp"

namespace multitetra {

struct Preview {
  // Grid steps, a power of two up to kMaxPreviewSpacing; 1 only where it is unsimplified or has
  // shells: what is simplified as well is the request itself.
  std::int32_t finest_spacing = 2;
  bool is_unsimplified = false;         // Though the request simplifies.
  std::optional<ShellStep> shell = {};  // None: Draco.

  friend bool operator==(const Preview&, const Preview&) = default;
};

inline constexpr std::int32_t kMaxPreviewSpacing = 1 << 19;
// The most previews of one stream: each refines the one before.
inline constexpr std::size_t kMaxPreviews = 20;

}  // namespace multitetra

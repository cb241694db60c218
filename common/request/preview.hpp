// Identifies a preview of a request by its finest spacing, and by whether it is unsimplified or has
// sample shells. Everything else follows from the request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/request/shell_step.hpp"

namespace multitetra {

struct Preview {
  // In grid steps: a power of two up to kMaxPreviewSpacing. 1 only if the preview is unsimplified
  // or has shells; otherwise it would be the final step.
  std::int32_t finest_spacing = 2;
  bool is_unsimplified = false;         // Although the request simplifies.
  std::optional<ShellStep> shell = {};  // Absent: Draco.

  friend bool operator==(const Preview&, const Preview&) = default;
};

inline constexpr std::int32_t kMaxPreviewSpacing = 1 << 19;
// The maximum number of previews in a stream: each refines the previous one.
inline constexpr std::size_t kMaxPreviews = 20;

}  // namespace multitetra

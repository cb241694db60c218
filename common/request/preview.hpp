// The name of a preview within its stream: where the model's hierarchy ends, and whether its
// surface is simplified. Everything else follows from the request.
#pragma once

#include <cstddef>
#include <cstdint>

namespace multitetra {

struct Preview {
  // Grid steps, a power of two up to kMaxPreviewSpacing; 1 only where it is unsimplified: what is
  // simplified as well is the request itself.
  std::int32_t finest_spacing = 2;
  bool is_unsimplified = false;  // Though the request simplifies.

  friend bool operator==(const Preview&, const Preview&) = default;
};

inline constexpr std::int32_t kMaxPreviewSpacing = 1 << 19;
inline constexpr std::size_t kMaxPreviews = 20;  // Of one stream: each refines the one before.

}  // namespace multitetra

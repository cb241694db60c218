// Untrusted text as one short line.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/base/utf8.hpp"

namespace multitetra {

// Returns printable() without line ends, cut to `max_bytes` bytes (at least 3) with "..." at the
// end. Idempotent.
[[nodiscard]] inline std::string printable_line(std::string_view text, std::size_t max_bytes) {
  // The printable form is never shorter than its source.
  std::string shown = printable(text.substr(0, 4 * max_bytes), /*keeps_lines=*/false);
  if (shown.size() <= max_bytes) return shown;
  std::size_t kept = max_bytes - 3;
  while (kept > 0 && (static_cast<unsigned char>(shown[kept]) & 0xC0) == 0x80) --kept;
  return shown.substr(0, kept) + "...";
}

}  // namespace multitetra

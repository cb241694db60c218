// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace multitetra {

[[nodiscard]] std::string human_bytes(std::uint64_t bytes);  // "12.3 MiB"
[[nodiscard]] std::string human_count(std::uint64_t count);  // "1 234 567"
[[nodiscard]] std::string human_seconds(double seconds);     // "24 ms", "1.25 s", "3 min 05 s"
[[nodiscard]] std::string human_number(double value);        // Shortest of up to 6 digits: "500.5"

}  // namespace multitetra

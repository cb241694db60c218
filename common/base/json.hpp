// JSON as text. Parser and printer are compiled once, not in each file that uses them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace multitetra {

// Parses untrusted text; is_discarded() if it is not JSON or has more than 256 levels. Its objects
// are sorted by key: looking up a key of an ordered_json takes time proportional to the number of
// keys.
[[nodiscard]] nlohmann::json parse_json(std::string_view text);

// Returns the text, with U+FFFD for bytes that are not UTF-8; on one line if `indent` is negative.
[[nodiscard]] std::string json_text(const nlohmann::json& json, int indent = -1);
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace multitetra

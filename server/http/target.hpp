// Parses the target of a request: "/v1/datasets/head%20a/isosurface?isovalue=5&region=..." Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

struct Target {
  std::string raw_path;           // As received, for comparisons and texts.
  std::vector<std::string> path;  // Segments, decoded: "/v1/a%20b" is "v1", "a b"; "/" has none.
  std::vector<std::pair<std::string, std::string>> query;  // In order, decoded.
};

// The bytes that `text` stands for; nullopt where % is not followed by two hexadecimal digits. "+"
// is itself: numbers have it.
[[nodiscard]] std::optional<std::string> percent_decoded(std::string_view text);

// The part after scheme, host and port of "http://example.org/path"; a path is itself.
[[nodiscard]] std::string_view without_authority(std::string_view target);

// kInvalidArgument unless it is a path, perhaps behind scheme, host and port, that begins with "/",
// perhaps with a query, all of it well encoded.
[[nodiscard]] Result<Target> parse_target(std::string_view target);

// `target` without the path under which a proxy shows the listener, as "/volumes", if it
// begins with it: "/volumes/v1/datasets" and "/v1/datasets" are the same.
[[nodiscard]] std::string_view without_base_path(std::string_view target,
                                                 std::string_view base_path);
// Whether it is the base path itself without a "/" at its end, which is redirected: relative links
// of a page start there.
[[nodiscard]] bool is_base_path(std::string_view target, std::string_view base_path);

// A base path as it is used, from "/volumes/" or "volumes": "/volumes"; empty for "/".
// kInvalidArgument where it has more than letters, digits and -._~/ in it.
[[nodiscard]] Result<std::string> parse_base_path(std::string_view text);

}  // namespace multitetra

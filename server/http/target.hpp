// Parses the target of a request: "/v1/datasets/head%20a/isosurface?isovalue=5&region=..." Pure.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

struct Target {
  std::string raw_path;           // The path as received.
  std::vector<std::string> path;  // Decoded segments: "/v1/a%20b" is "v1", "a b"; "/" has none.
  std::vector<std::pair<std::string, std::string>> query;  // Decoded, in order.
};

// Strips scheme, host and port: returns "/path" for "http://example.org/path" or "/path".
[[nodiscard]] std::string_view without_authority(std::string_view target);

// Parses a path that begins with "/", optionally after scheme, host and port, and optionally with a
// query. Returns kInvalidArgument for anything else or an invalid encoding.
[[nodiscard]] Result<Target> parse_target(std::string_view target);

// Strips the base path, under which a proxy exposes the listener: for "/volumes",
// "/volumes/v1/datasets" becomes "/v1/datasets"; other targets are unchanged.
[[nodiscard]] std::string_view without_base_path(std::string_view target,
                                                 std::string_view base_path);
// Returns whether it is the base path without a trailing "/". Redirected, as a page's relative
// links depend on the slash.
[[nodiscard]] bool is_base_path(std::string_view target, std::string_view base_path);

// Normalizes a base path: "/volumes/" and "volumes" become "/volumes", "/" becomes empty. Returns
// kInvalidArgument for characters other than letters, digits and -._~/.
[[nodiscard]] Result<std::string> parse_base_path(std::string_view text);

}  // namespace multitetra

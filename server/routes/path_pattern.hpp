// Patterns of paths, such as "/v1/datasets/{name}/slice": {name} stands for one segment, and a last
// {path...} for all that follow. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/target.hpp"

namespace multitetra {

// The decoded segments that the parameters of a pattern stand for, in order.
using PathValues = std::vector<std::string>;

class PathPattern {
 public:
  // `text` must outlive the pattern.
  PathPattern(const char* text);  // NOLINT: patterns are written as texts.

  [[nodiscard]] std::optional<PathValues> match(const std::vector<std::string>& path) const;

 private:
  std::vector<std::string_view> segments_;
};

// A path that begins with "/v1/token/TOKEN", without these segments.
struct PathWithToken {
  std::string token;
  std::vector<std::string> path;  // Begins with "v1".
};
[[nodiscard]] std::optional<PathWithToken> path_with_token(const Target& target);

// Returns the target for logs: a token in its path becomes "...".
[[nodiscard]] std::string without_token(std::string_view target);

}  // namespace multitetra

#include "server/routes/path_pattern.hpp"

#include <algorithm>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kTokens = "/v1/token/";

}  // namespace

PathPattern::PathPattern(const char* text)
    : segments_(split(std::string_view(text).substr(1), '/')) {}

std::optional<PathValues> PathPattern::match(const std::vector<std::string>& path) const {
  PathValues values;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const std::string_view segment = segments_[i];
    if (segment.ends_with("...}")) {
      values.insert(values.end(), path.begin() + static_cast<std::ptrdiff_t>(i), path.end());
      return values;
    }
    if (i >= path.size()) return std::nullopt;
    if (segment.starts_with('{')) {
      values.push_back(path[i]);
    } else if (segment != path[i]) {
      return std::nullopt;
    }
  }
  if (path.size() != segments_.size()) return std::nullopt;
  return values;
}

// Tests the undecoded path, as without_token() does.
std::optional<PathWithToken> path_with_token(const Target& target) {
  if (target.path.size() <= 3 || !target.raw_path.starts_with(kTokens)) return std::nullopt;
  PathWithToken found{.token = target.path[2], .path = {"v1"}};
  found.path.insert(found.path.end(), target.path.begin() + 3, target.path.end());
  return found;
}

std::string without_token(std::string_view target) {
  const std::size_t at = target.find(kTokens);
  if (at == std::string_view::npos) return std::string(target);
  const std::size_t token = at + kTokens.size();
  const std::size_t end = std::min(target.find_first_of("/?", token), target.size());
  return std::string(target.substr(0, token)) + "..." + std::string(target.substr(end));
}

}  // namespace multitetra

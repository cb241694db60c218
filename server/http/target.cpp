#include "server/http/target.hpp"

#include <algorithm>

#include "common/base/percent_encoded.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

bool add_parameter(std::string_view text, Target& target) {
  if (text.empty()) return true;
  const std::size_t equals = text.find('=');
  auto name = percent_decoded(text.substr(0, equals));
  auto value = percent_decoded(equals == std::string_view::npos ? std::string_view()
                                                                : text.substr(equals + 1));
  if (!name || !value) return false;
  target.query.emplace_back(*std::move(name), *std::move(value));
  return true;
}

}  // namespace

std::string_view without_authority(std::string_view target) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!target.starts_with(scheme)) continue;
    const std::size_t end = target.find_first_of("/?", scheme.size());
    return end == std::string_view::npos ? "/" : target.substr(end);
  }
  return target;
}

Result<Target> parse_target(std::string_view requested) {
  const std::string_view target = without_authority(requested);
  if (!target.starts_with('/')) {
    return fail(ErrorCode::kInvalidArgument, "The request's target must begin with \"/\".");
  }
  const std::size_t mark = target.find('?');
  const std::string_view path = target.substr(0, mark);
  Target parts{.raw_path = std::string(path), .path = {}, .query = {}};
  const auto wrong_percent = [] {
    return fail(ErrorCode::kInvalidArgument,
                "The request's target has a % that is not followed by two hexadecimal digits.");
  };
  for (const std::string_view segment : split(path.substr(1), '/')) {
    auto decoded = percent_decoded(segment);
    if (!decoded) return wrong_percent();
    parts.path.push_back(*std::move(decoded));
  }
  if (path.size() == 1) parts.path.clear();
  if (mark == std::string_view::npos) return parts;
  for (const std::string_view parameter : split(target.substr(mark + 1), '&')) {
    if (!add_parameter(parameter, parts)) return wrong_percent();
  }
  return parts;
}

std::string_view without_base_path(std::string_view target, std::string_view base_path) {
  const bool is_below = !base_path.empty() && target.size() > base_path.size() &&
                        target.starts_with(base_path) && target[base_path.size()] == '/';
  return is_below ? target.substr(base_path.size()) : target;
}

bool is_base_path(std::string_view target, std::string_view base_path) {
  return !base_path.empty() && target.substr(0, target.find('?')) == base_path;
}

Result<std::string> parse_base_path(std::string_view text) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("-._~/").find(c) != std::string_view::npos;
  };
  if (!std::all_of(text.begin(), text.end(), is_plain) || text.find("//") != text.npos) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) + "\" is not a URL path; write for example /volumes.");
  }
  while (text.ends_with('/')) text.remove_suffix(1);
  while (text.starts_with('/')) text.remove_prefix(1);
  return text.empty() ? std::string() : "/" + std::string(text);
}

}  // namespace multitetra

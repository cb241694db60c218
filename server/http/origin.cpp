#include "server/http/origin.hpp"
#include "common/base/text.hpp"

#include <algorithm>
#include <cctype>
#include <regex>

namespace multitetra {
namespace {

// Browsers omit the default port of a scheme.
std::string without_port(std::string text, std::string_view port) {
  if (text.ends_with(port)) text.resize(text.size() - port.size());
  return text;
}

}  // namespace

bool is_allowed_origin(std::string_view origin, std::string_view host,
                       const std::vector<std::string>& allowed) {
  if (origin.empty()) return true;
  const std::string from = lower_case(origin);
  const auto is_it = [&](const std::string& one) { return one == "*" || lower_case(one) == from; };
  if (std::any_of(allowed.begin(), allowed.end(), is_it)) return true;
  const std::string at = lower_case(host);
  for (const auto& [scheme, port] :
       {std::pair<std::string_view, std::string_view>{"http://", ":80"}, {"https://", ":443"}}) {
    if (from.starts_with(scheme)) {
      const std::string own = without_port(from.substr(scheme.size()), port);
      return !own.empty() && own == without_port(at, port);
    }
  }
  return false;
}

namespace {

bool is_another_allowed(std::string_view origin, std::string_view host,
                        const std::vector<std::string>& allowed) {
  return std::find(allowed.begin(), allowed.end(), "*") != allowed.end() ||
         (!origin.empty() && is_allowed_origin(origin, host, allowed));
}

}  // namespace

bool is_from_other_site(std::string_view site, std::string_view origin, std::string_view host,
                        const std::vector<std::string>& allowed) {
  return site == "cross-site" && !is_another_allowed(origin, host, allowed);
}

std::string_view resource_policy(std::string_view origin, std::string_view host,
                                 const std::vector<std::string>& allowed) {
  return is_another_allowed(origin, host, allowed) ? "cross-origin" : "same-origin";
}

bool is_origin(std::string_view text) {
  static const std::regex kOrigin(
      R"(\*|[a-z][a-z0-9+.-]*://(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(:[0-9]{1,5})?)", std::regex::icase);
  return std::regex_match(text.begin(), text.end(), kOrigin);
}

std::string cross_origin_fields(std::string_view origin, std::string_view host,
                                const std::vector<std::string>& allowed, bool is_preflight) {
  if (allowed.empty()) return {};
  std::string fields = "Vary: Origin\r\n";
  if (origin.empty() || !is_allowed_origin(origin, host, allowed)) return fields;
  fields.append("Access-Control-Allow-Origin: ").append(origin);
  fields +=
      "\r\nAccess-Control-Expose-Headers: ETag, Content-Range, X-Request-Id, Multitetra-Notice, "
      "Multitetra-Triangles, Multitetra-Vertices, Multitetra-Euler-Characteristic, "
      "Multitetra-Components, Multitetra-Components-Written, Multitetra-Error-Bound, "
      "Multitetra-Length-Unit, Multitetra-Space, Multitetra-Content-Digest, Multitetra-Width, "
      "Multitetra-Height, Multitetra-Origin, "
      "Multitetra-Right, Multitetra-Down, Multitetra-Sample-Spacing\r\n";
  if (is_preflight) {
    fields +=
        "Access-Control-Allow-Methods: GET, HEAD, OPTIONS\r\n"
        "Access-Control-Allow-Headers: Authorization, If-None-Match, If-Range, Range\r\n"
        "Access-Control-Max-Age: 86400\r\n";
  }
  return fields;
}

}  // namespace multitetra

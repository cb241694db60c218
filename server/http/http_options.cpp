#include "server/http/http_options.hpp"

namespace multitetra {

Result<Endpoint> parse_http_endpoint(std::string_view text) {
  constexpr std::string_view kScheme = "http://";
  const std::string_view rest = text.starts_with(kScheme) ? text.substr(kScheme.size()) : text;
  auto endpoint = parse_endpoint(rest);
  const bool is_port = rest.find_first_not_of("0123456789") == std::string_view::npos;
  const bool has_port =
      is_port || (!rest.ends_with(']') && rest.find(':') != std::string_view::npos);
  if (!endpoint || !has_port) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) +
                    "\" is not an address for HTTP; write HOST:PORT or PORT, for example " +
                    http_url(HttpOptions{}.listen) + ".");
  }
  return endpoint;
}

std::string http_url(const Endpoint& endpoint, bool is_secure) {
  std::string url = to_string(endpoint);
  url.replace(0, url.find(':'), is_secure ? "https" : "http");
  return url;
}

}  // namespace multitetra

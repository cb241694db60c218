// The web pages that may use a listener: its own, and those of allowed origins.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// `origin` is the Origin field of a request, such as "https://example.org:8443"; an empty one, from
// other programs than browsers, is allowed. `host` is the Host field: a page of the same host and
// port is allowed with any scheme, as a proxy may change it. "*" in `allowed` allows all.
[[nodiscard]] bool is_allowed_origin(std::string_view origin, std::string_view host,
                                     const std::vector<std::string>& allowed);

// Returns whether the text is a valid entry of `allowed`: an origin as browsers write it (scheme,
// host, and the port unless it is the default), or "*".
[[nodiscard]] bool is_origin(std::string_view text);

// Returns the CORS header fields that let a page of `origin` read an answer; empty if not allowed
// or unnecessary. For "OPTIONS", includes what such a page may send.
[[nodiscard]] std::string cross_origin_fields(std::string_view origin, std::string_view host,
                                              const std::vector<std::string>& allowed,
                                              bool is_preflight);

// Returns whether a page of another site, which is not allowed, made the browser send a request.
// `site` is its Sec-Fetch-Site; browsers send no Origin for pictures and links.
[[nodiscard]] bool is_from_other_site(std::string_view site, std::string_view origin,
                                      std::string_view host,
                                      const std::vector<std::string>& allowed);

// Returns the Cross-Origin-Resource-Policy of an answer, which keeps pictures and scripts of other
// sites from using it.
[[nodiscard]] std::string_view resource_policy(std::string_view origin, std::string_view host,
                                               const std::vector<std::string>& allowed);

}  // namespace multitetra

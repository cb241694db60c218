// The web pages that may use a listener: its own, and those of allowed origins.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// `origin` is the Origin field of a request, "https://example.org:8443"; empty, from a program that
// is no browser, is allowed. `host` is the Host field: a page of the same host and port is allowed,
// whichever scheme a proxy in front made of it. "*" among the allowed ones allows all.
[[nodiscard]] bool is_allowed_origin(std::string_view origin, std::string_view host,
                                     const std::vector<std::string>& allowed);

// Whether an allowed origin is written as browsers write theirs: scheme, host, and the port unless
// it is the usual one; or "*".
[[nodiscard]] bool is_origin(std::string_view text);

// The header fields (CORS) by which the browser lets a page of `origin` read an answer; empty where
// it may not, or where there is nothing to say. For "OPTIONS", also what such a page may send.
[[nodiscard]] std::string cross_origin_fields(std::string_view origin, std::string_view host,
                                              const std::vector<std::string>& allowed,
                                              bool is_preflight);

}  // namespace multitetra

// Which web pages may use a door: its own, and those of allowed origins.
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

}  // namespace multitetra

// The host names that a listener accepts. This prevents DNS rebinding: a page that resolves its own
// name to the user's machine would pass every check of origins.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// `host` is the Host field of a request, "example.org:8443"; its port does not count. Addresses and
// "localhost" are always allowed, since no page can give itself these names, and so is an empty
// field, which browsers never send. "example.org" among the allowed ones is that name alone,
// ".example.org" also every name below it, "*" every one.
[[nodiscard]] bool is_allowed_host(std::string_view host, const std::vector<std::string>& allowed);

// Whether an allowed host is written as above: a name without scheme, port and path.
[[nodiscard]] bool is_host_pattern(std::string_view text);

}  // namespace multitetra

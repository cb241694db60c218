// The host names that a listener accepts. Prevents DNS rebinding: a page that resolves its own name
// to the user's machine would pass every origin check.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// `host` is the Host field of a request, such as "example.org:8443"; the port is ignored. Always
// allows addresses and "localhost", as no page can have these names, and an empty field, which
// browsers never send. In `allowed`, "example.org" is that name only, ".example.org" also all names
// below it, "*" all names.
[[nodiscard]] bool is_allowed_host(std::string_view host, const std::vector<std::string>& allowed);

// Returns whether the text is a valid entry of `allowed`: a name without scheme, port and path.
[[nodiscard]] bool is_host_pattern(std::string_view text);

}  // namespace multitetra

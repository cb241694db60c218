// Whom limits are counted for: the address of a client, also behind a proxy.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// The name under which limits count: an IPv4 address itself, of an IPv6 address its /64 network,
// for one subscriber has all of that. What is no address is its own name.
[[nodiscard]] std::string limited_name(std::string_view address);

// Who asks, behind proxies that are trusted to say so: `peer` itself unless it is one of
// `trusted`; else the last address of X-Forwarded-For (the header's value) that no trusted proxy
// has. So nobody chooses an address for himself. Addresses are compared as addresses, not as text.
[[nodiscard]] std::string client_behind(std::string_view peer, std::string_view forwarded_for,
                                        const std::vector<std::string>& trusted);

// Whether a proxy of that address is trusted.
[[nodiscard]] bool is_among(std::string_view address, const std::vector<std::string>& trusted);

}  // namespace multitetra

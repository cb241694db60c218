// The address of a client for limits, also behind a proxy.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// The name under which limits count: an IPv4 address itself, of an IPv6 address its /64 network,
// for one subscriber has all of that. What is no address is its own name.
[[nodiscard]] std::string limited_name(std::string_view address);

// One of the groups that a share belongs to, and for how many shares the group counts at most.
struct ShareLevel {
  std::string name;
  int shares = 1;

  friend bool operator==(const ShareLevel&, const ShareLevel&) = default;
};
// The share itself first. A share that ends in an IPv6 network, as limited_name() gives it, also
// belongs to the /56 and the /48 around it, which count for 2 and for 4 shares: a client with a
// large network has many /64 networks, but no more than that of the server.
[[nodiscard]] std::vector<ShareLevel> share_levels(const std::string& share);

// Addresses and networks.
class AddressRanges {
 public:
  // Each text is an address, or a network such as "10.0.0.0/8" or "2001:db8::/32". kInvalidArgument
  // with the first text that is neither.
  [[nodiscard]] static Result<AddressRanges> parse(const std::vector<std::string>& texts);

  // Addresses are compared as addresses, not as text.
  [[nodiscard]] bool contains(std::string_view address) const;

 private:
  // IPv4 as IPv6 has it.
  struct Range {
    std::array<unsigned char, 16> network = {};
    // The significant bits of the network.
    int bits = 128;
  };
  std::vector<Range> ranges_;
};

// The address of a client, possibly behind trusted proxies.
struct ForwardedClient {
  std::string address;
  // A trusted proxy without a client's address: limits per address do not apply.
  bool is_trusted = false;
};
// `peer` itself unless it is one of `trusted`; else the last address of X-Forwarded-For (the lines'
// values, joined by commas) that is no trusted proxy's. So a client cannot choose its address. An
// address may have a port, and brackets. If the last word is no address, the proxy that added it
// counts as the client.
[[nodiscard]] ForwardedClient forwarded_client(std::string_view peer,
                                               std::string_view forwarded_for,
                                               const AddressRanges& trusted);

}  // namespace multitetra

// The client address that limits apply to, including behind proxies.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// Returns the name that limits apply to: an IPv4 address itself, but the /64 network of an IPv6
// address, as one subscriber has all of it. Other text is returned unchanged.
[[nodiscard]] std::string limit_key(std::string_view address);

// A group that a share belongs to, and the number of shares that the group counts for.
struct ShareLevel {
  std::string name;
  int shares = 1;

  friend bool operator==(const ShareLevel&, const ShareLevel&) = default;
};
// Returns the groups of a share, first itself. A share with an IPv6 network, as from
// limit_key(), also belongs to the enclosing /56 and /48, which count for 2 and 4 shares. So a
// client with a large network and many /64 networks gets only a few shares.
[[nodiscard]] std::vector<ShareLevel> share_levels(const std::string& share);

// A set of addresses and networks.
class AddressRanges {
 public:
  // Parses addresses and networks, such as "10.0.0.0/8" or "2001:db8::/32". Returns
  // kInvalidArgument with the first invalid text.
  [[nodiscard]] static Result<AddressRanges> parse(const std::vector<std::string>& texts);

  // Compares addresses by value, not as text.
  [[nodiscard]] bool contains(std::string_view address) const;

 private:
  // IPv4 addresses are stored IPv4-mapped.
  struct Range {
    std::array<unsigned char, 16> network = {};
    // The length of the network prefix.
    int bits = 128;
  };
  std::vector<Range> ranges_;
};

// A client's address, possibly behind trusted proxies.
struct ForwardedClient {
  std::string address;
  // A trusted proxy without a client address: limits per address do not apply.
  bool is_trusted = false;
};
// Returns `peer` unless it is in `trusted`; otherwise the last address of X-Forwarded-For (the
// lines' values, joined by commas) that is not a trusted proxy, so a client cannot choose its
// address. Addresses may have a port and brackets. If the last entry is not an address, returns the
// proxy that added it.
[[nodiscard]] ForwardedClient forwarded_client(std::string_view peer,
                                               std::string_view forwarded_for,
                                               const AddressRanges& trusted);

}  // namespace multitetra

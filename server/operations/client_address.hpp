// Whom limits are counted for: the address of a client, also behind a proxy.
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

// Addresses and networks.
class AddressRanges {
 public:
  // Each text is an address, or a network as "10.0.0.0/8" or "2001:db8::/32". kInvalidArgument that
  // says which of them is neither.
  [[nodiscard]] static Result<AddressRanges> parse(const std::vector<std::string>& texts);

  // Addresses are compared as addresses, not as text.
  [[nodiscard]] bool contains(std::string_view address) const;

 private:
  // IPv4 as IPv6 has it.
  struct Range {
    std::array<unsigned char, 16> network = {};
    int bits = 128;  // Of the network that count.
  };
  std::vector<Range> ranges_;
};

// Who asks, behind proxies that are trusted to say so.
struct ClientBehind {
  std::string address;
  bool is_trusted = false;  // A proxy that speaks for nobody: limits of one address do not hold.
};
// `peer` itself unless it is one of `trusted`; else the last address of X-Forwarded-For (the lines'
// values, joined by commas) that no trusted proxy has. So nobody chooses an address for himself. An
// address may have a port, and brackets. Where the last word is none, the proxy that added it is
// taken for the client, with a client's limits.
[[nodiscard]] ClientBehind client_behind(std::string_view peer, std::string_view forwarded_for,
                                         const AddressRanges& trusted);

}  // namespace multitetra

#include "server/operations/client_address.hpp"

#include <algorithm>
#include <optional>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/net/net.hpp"

namespace multitetra {
namespace {

using Bytes = std::array<unsigned char, 16>;

// Parses an address. An IPv4-mapped IPv6 address, as on dual-stack sockets, becomes IPv4.
std::optional<asio::ip::address> parsed(std::string_view text) {
  boost::system::error_code error;
  const asio::ip::address address = asio::ip::make_address(std::string(text), error);
  if (error) return std::nullopt;
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  }
  return address;
}

Bytes bytes_of(const asio::ip::address& address) {
  return address.is_v6()
             ? address.to_v6().to_bytes()
             : asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4()).to_bytes();
}

std::optional<int> number(std::string_view text, int max_value) {
  const auto value = parse_number<int>(text);
  return value && *value >= 0 && *value <= max_value ? value : std::nullopt;
}

// Parses the forms that proxies use: 192.0.2.7, 192.0.2.7:4711, 2001:db8::7, [2001:db8::7],
// [2001:db8::7]:4711.
std::optional<asio::ip::address> parsed_hop(std::string_view text) {
  constexpr int kMaxPort = 65'535;
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    port = text.substr(end + 1);
    text = text.substr(1, end - 1);
  } else if (std::count(text.begin(), text.end(), ':') == 1) {
    port = text.substr(text.find(':'));
    text = text.substr(0, text.find(':'));
  }
  if (!port.empty() && (!port.starts_with(':') || !number(port.substr(1), kMaxPort))) {
    return std::nullopt;
  }
  return parsed(text);
}

bool agree(const Bytes& a, const Bytes& b, int bits) {
  for (int i = 0; i < bits; ++i) {
    const auto byte = static_cast<std::size_t>(i / 8);
    if (((a[byte] ^ b[byte]) >> (7 - i % 8) & 1) != 0) return false;
  }
  return true;
}

// The smallest network of an IPv6 subscriber.
constexpr std::size_t kBytesOfASubnet = 8;
constexpr std::string_view kSubnetSuffix = "/64";

// Returns the network of an address's first bytes, such as "2001:db8:1:2::/64".
std::string network_of(const asio::ip::address_v6& address, std::size_t bytes) {
  Bytes network = address.to_bytes();
  std::fill(network.begin() + static_cast<std::ptrdiff_t>(bytes), network.end(), 0);
  return asio::ip::address_v6(network).to_string() + '/' + std::to_string(8 * bytes);
}

}  // namespace

std::string limit_key(std::string_view address) {
  const auto found = parsed(address);
  if (!found) return std::string(address);
  if (found->is_v4()) return found->to_string();
  return network_of(found->to_v6(), kBytesOfASubnet);
}

std::vector<ShareLevel> share_levels(const std::string& share) {
  std::vector<ShareLevel> levels = {{.name = share}};
  if (!share.ends_with(kSubnetSuffix)) return levels;
  const std::size_t space = share.rfind(' ');
  const std::size_t first = space == std::string::npos ? 0 : space + 1;
  const auto found = parsed(share.substr(first, share.size() - first - kSubnetSuffix.size()));
  if (!found || !found->is_v6()) return levels;
  const std::string before = share.substr(0, first);
  levels.push_back({.name = before + network_of(found->to_v6(), 7), .shares = 2});
  levels.push_back({.name = before + network_of(found->to_v6(), 6), .shares = 4});
  return levels;
}

Result<AddressRanges> AddressRanges::parse(const std::vector<std::string>& texts) {
  AddressRanges ranges;
  for (const std::string& text : texts) {
    const std::size_t slash = text.find('/');
    const auto address = parsed(text.substr(0, slash));
    const int max_bits = address && address->is_v4() ? 32 : 128;
    const auto bits = slash == std::string::npos ? std::optional(max_bits)
                                                 : number(text.substr(slash + 1), max_bits);
    if (!address || !bits) {
      return fail(ErrorCode::kInvalidArgument,
                  "\"" + text +
                      "\" is neither an address nor a network; write for example 192.0.2.7, "
                      "10.0.0.0/8 or 2001:db8::/32.");
    }
    ranges.ranges_.push_back({bytes_of(*address), 128 - max_bits + *bits});
  }
  return ranges;
}

bool AddressRanges::contains(std::string_view address) const {
  const auto wanted = parsed(address);
  if (!wanted) return false;
  const Bytes bytes = bytes_of(*wanted);
  return std::any_of(ranges_.begin(), ranges_.end(),
                     [&](const Range& range) { return agree(bytes, range.network, range.bits); });
}

ForwardedClient forwarded_client(std::string_view peer, std::string_view forwarded_for,
                                 const AddressRanges& trusted) {
  std::string client(peer);
  bool is_more = !trimmed(forwarded_for).empty();
  while (trusted.contains(client)) {
    if (!is_more) return {.address = std::move(client), .is_trusted = true};
    const std::size_t comma = forwarded_for.find_last_of(',');
    is_more = comma != std::string_view::npos;
    const auto hop = parsed_hop(trimmed(is_more ? forwarded_for.substr(comma + 1) : forwarded_for));
    if (!hop) break;
    client = hop->to_string();
    forwarded_for = forwarded_for.substr(0, is_more ? comma : 0);
  }
  return {.address = std::move(client)};
}

}  // namespace multitetra

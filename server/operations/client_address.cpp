#include "server/operations/client_address.hpp"

#include <algorithm>
#include <optional>

#include "common/base/text.hpp"
#include "common/net/net.hpp"

namespace multitetra {
namespace {

// An IPv4 address in an IPv6 one is the former, as on sockets that speak both.
std::optional<asio::ip::address> parsed(std::string_view text) {
  boost::system::error_code error;
  const asio::ip::address address = asio::ip::make_address(std::string(text), error);
  if (error) return std::nullopt;
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  }
  return address;
}

}  // namespace

std::string limited_name(std::string_view address) {
  const auto found = parsed(address);
  if (!found) return std::string(address);
  if (found->is_v4()) return found->to_string();
  auto bytes = found->to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  return asio::ip::address_v6(bytes).to_string() + "/64";
}

bool is_among(std::string_view address, const std::vector<std::string>& trusted) {
  const auto wanted = parsed(address);
  return wanted && std::any_of(trusted.begin(), trusted.end(),
                               [&](const std::string& proxy) { return parsed(proxy) == wanted; });
}

std::string client_behind(std::string_view peer, std::string_view forwarded_for,
                          const std::vector<std::string>& trusted) {
  std::string client(peer);
  while (is_among(client, trusted)) {
    const std::size_t comma = forwarded_for.find_last_of(',');
    const std::string_view last =
        trimmed(comma == std::string_view::npos ? forwarded_for : forwarded_for.substr(comma + 1));
    if (!parsed(last)) break;
    client = last;
    forwarded_for = comma == std::string_view::npos ? "" : forwarded_for.substr(0, comma);
  }
  return client;
}

}  // namespace multitetra

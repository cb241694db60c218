#include "client/load/source_addresses.hpp"

#include "common/base/parse_number.hpp"
#include "common/net/net.hpp"

namespace multitetra {

Result<SourceAddresses> SourceAddresses::from(std::string_view text) {
  const std::size_t slash = text.find('/');
  const auto bits = slash == std::string_view::npos
                        ? std::optional<std::uint32_t>(32)
                        : parse_number<std::uint32_t>(text.substr(slash + 1));
  error_code error;
  const auto address = asio::ip::make_address_v4(std::string(text.substr(0, slash)), error);
  if (error || !bits || *bits < 8 || *bits > 32) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) +
                    "\" is not an IPv4 address or network; write for example 127.0.1.0/24.");
  }
  SourceAddresses addresses;
  const std::uint64_t size = std::uint64_t{1} << (32 - *bits);
  const bool has_ends = size > 2;  // The network address and the broadcast address.
  addresses.first_ =
      static_cast<std::uint32_t>(address.to_uint() & ~(size - 1)) + (has_ends ? 1 : 0);
  addresses.count_ = static_cast<std::size_t>(has_ends ? size - 2 : size);
  return addresses;
}

std::string SourceAddresses::of(std::size_t client) const {
  if (count_ == 0) return {};
  return asio::ip::address_v4(first_ + static_cast<std::uint32_t>(client % count_)).to_string();
}

}  // namespace multitetra

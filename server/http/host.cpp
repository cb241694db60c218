#include "server/http/host.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

// Strips the port: "[::1]:80" becomes "::1", "example.org.:80" becomes "example.org".
std::string_view name_in(std::string_view host) {
  if (host.starts_with('[')) return host.substr(1, host.find(']') - 1);
  host = host.substr(0, host.find(':'));
  if (host.ends_with('.')) host.remove_suffix(1);
  return host;
}

bool is_address(std::string_view name) {
  boost::system::error_code error;
  boost::asio::ip::make_address(name, error);
  return !error;
}

bool is_or_is_below(std::string_view name, std::string_view domain) {
  return name == domain || (name.size() > domain.size() && name.ends_with(domain) &&
                            name[name.size() - domain.size() - 1] == '.');
}

}  // namespace

bool is_allowed_host(std::string_view host, const std::vector<std::string>& allowed) {
  const std::string name = lower_case(name_in(host));
  if (host.empty() || is_or_is_below(name, "localhost") || is_address(name)) return true;
  return std::any_of(allowed.begin(), allowed.end(), [&](const std::string& one) {
    const std::string pattern = lower_case(one);
    if (pattern == "*") return true;
    return pattern.starts_with('.') ? is_or_is_below(name, std::string_view(pattern).substr(1))
                                    : name == pattern;
  });
}

bool is_host_pattern(std::string_view text) {
  if (text == "*") return true;
  if (text.starts_with('.')) text.remove_prefix(1);
  return !text.empty() && text.find_first_not_of(
                              "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                              "0123456789-_.") == std::string_view::npos;
}

}  // namespace multitetra

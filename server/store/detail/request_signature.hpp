// Signs requests to buckets: AWS Signature Version 4, as an Authorization header. libcurl's own
// differs between versions: that of 8.14 signs "%2B" in queries as a space, that of 7.88 has no
// digest of the body.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

struct SigningKey {
  std::string id;  // Empty: requests are not signed.
  std::string secret;
  std::string session = {};  // Of temporary credentials; empty: none.
  std::string region;
};

// Returns the headers to add to a request. `url`: http or https, without user and fragment, its
// path and query percent-encoded.
[[nodiscard]] std::vector<std::string> signature_headers(const SigningKey& key,
                                                         std::string_view method,
                                                         std::string_view url,
                                                         std::span<const std::byte> body,
                                                         std::chrono::system_clock::time_point now);

}  // namespace multitetra

#include "server/store/detail/resolved_url.hpp"

#include <cstdlib>
#include <string_view>

#include "common/base/percent_encoded.hpp"
#include "server/store/http_options.hpp"
#include "server/store/store_error.hpp"

namespace multitetra {

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

std::string aws_region() {
  std::string region = environment("AWS_REGION");
  if (region.empty()) region = environment("AWS_DEFAULT_REGION");
  return region.empty() ? "us-east-1" : region;
}

bool is_address(std::string_view text) {
  return text.starts_with("http://") || text.starts_with("https://") || text.starts_with("s3://");
}

ResolvedUrl resolved_url(const std::string& address) {
  if (!is_address(address)) {
    throw StoreError(address, "it is not an address", "Write http://, https:// or s3://");
  }
  const bool is_s3 = address.starts_with("s3://");
  const std::string rest = address.substr(address.find("//") + 2);
  const std::string host = rest.substr(0, rest.find('/'));
  const std::string path = rest.size() > host.size() ? rest.substr(host.size()) : "/";
  if (host.empty()) {
    throw StoreError(address, is_s3 ? "it has no bucket" : "it has no host",
                     is_s3 ? "Write s3://bucket/path" : "Write https://host/path");
  }
  if (!is_s3)
    return {.is_s3 = false,
            .origin = address.substr(0, address.size() - rest.size()) + host,
            .path = path};
  std::string endpoint = environment("AWS_ENDPOINT_URL");
  while (endpoint.ends_with('/')) endpoint.pop_back();
  return {.is_s3 = true,
          .origin = endpoint.empty() ? "https://" + host + ".s3." + aws_region() + ".amazonaws.com"
                                     : endpoint + "/" + host,
          .path = percent_encoded(path, "/")};
}

}  // namespace multitetra

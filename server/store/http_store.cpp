#include "server/store/http_store.hpp"

#include <algorithm>
#include <utility>

#include "common/base/address_text.hpp"
#include "common/base/percent_encoded.hpp"
#include "server/store/detail/resolved_url.hpp"
#include "server/store/detail/store_client.hpp"

namespace multitetra {
namespace {

class HttpStore : public ObjectStore {
 public:
  HttpStore(std::string base, bool is_s3, const HttpStoreOptions& options)
      : base_(std::move(base)),
        allow_other_hosts_(options.allow_other_hosts),
        client_(is_s3, options) {}

  std::optional<std::vector<std::byte>> get(const std::string& key,
                                            std::uint64_t max_bytes) override {
    return fetched({.address = address_of(key), .most = max_bytes});
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    if (length == 0) return std::vector<std::byte>();
    return fetched({.address = address_of(key),
                    .range = StoreRange{.first = offset, .length = length},
                    .most = length});
  }

  [[nodiscard]] std::filesystem::path place(const std::string& key) const override {
    return without_password(base_ + key);
  }
  [[nodiscard]] std::size_t parallel_requests() const override { return client_.connections(); }

 private:
  // Keys come from metadata: escapes all characters that are special in URLs.
  [[nodiscard]] std::string address_of(const std::string& key) const {
    const std::filesystem::path inside(key);
    const bool leads_out = std::find(inside.begin(), inside.end(), "..") != inside.end();
    if (leads_out && !allow_other_hosts_) {
      throw StoreError(base_, "it refers to '" + key + "', which is outside its address",
                       "Correct its metadata, or allow it with --follow if you trust them");
    }
    return base_ + percent_encoded(key, "/!$&'()*+,;=:@");
  }

  std::optional<std::vector<std::byte>> fetched(const StoreRequest& request) {
    HttpAnswer answer = client_.send(request);
    if (answer.is_good()) return std::move(answer.bytes);
    if (answer.status == 404 || answer.status == 410) return std::nullopt;
    if (answer.status == 401 || answer.status == 403) {
      throw StoreAccessDenied(
          request.address,
          "the server rejected the request with status " + std::to_string(answer.status),
          "Check the credentials; a bucket that must not be listed also returns this for missing "
          "objects");
    }
    throw StoreError(request.address, "the server returned status " + std::to_string(answer.status),
                     "Check the address, the network and the credentials");
  }

  // Ends with '/'.
  std::string base_;
  bool allow_other_hosts_;
  StoreClient client_;
};

}  // namespace

std::unique_ptr<ObjectStore> http_store(const std::string& address,
                                        const HttpStoreOptions& options) {
  const ResolvedUrl place = resolved_url(address);
  std::string base = place.address();
  if (!base.ends_with('/')) base += '/';
  return std::make_unique<HttpStore>(std::move(base), place.is_s3, options);
}

}  // namespace multitetra

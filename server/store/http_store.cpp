#include "server/store/http_store.hpp"

#include <utility>

#include "server/store/detail/store_client.hpp"

namespace multitetra {
namespace {

class HttpStore : public ObjectStore {
 public:
  HttpStore(std::string base, bool is_s3, const HttpStoreOptions& options)
      : base_(std::move(base)), client_(is_s3, options) {}

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    return fetched({.address = base_ + key, .most = most});
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    if (length == 0) return std::vector<std::byte>();
    return fetched({.address = base_ + key,
                    .range = ByteRange{.first = offset, .length = length},
                    .most = length});
  }

  [[nodiscard]] std::filesystem::path place(const std::string& key) const override {
    return base_ + key;
  }
  [[nodiscard]] std::size_t parallel_requests() const override { return client_.connections(); }

 private:
  std::optional<std::vector<std::byte>> fetched(const HttpRequest& request) {
    HttpAnswer answer = client_.send(request);
    if (answer.is_good()) return std::move(answer.bytes);
    // What buckets say of objects that are not there, with and without the right to list them.
    if (answer.status == 404 || answer.status == 410 || answer.status == 403) return std::nullopt;
    throw StoreError(request.address,
                     "the server answers with status " + std::to_string(answer.status),
                     "Check the address, the network and the credentials");
  }

  std::string base_;  // Ends in '/'.
  StoreClient client_;
};

}  // namespace

std::unique_ptr<ObjectStore> http_store(const std::string& address,
                                        const HttpStoreOptions& options) {
  const HttpPlace place = http_place(address);
  std::string base = place.address();
  if (!base.ends_with('/')) base += '/';
  return std::make_unique<HttpStore>(std::move(base), place.is_s3, options);
}

}  // namespace multitetra

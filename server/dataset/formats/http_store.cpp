#include "server/dataset/formats/http_store.hpp"

#include <curl/curl.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <utility>

#include "server/dataset/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr int kTries = 4;
constexpr long kConnectSeconds = 20;
constexpr long kStalledSeconds = 60;  // Below 1 byte a second.
constexpr std::size_t kParallelRequests = 16;

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

// What a request is for, and what has come of it.
struct Transfer {
  std::vector<std::byte> bytes;
  std::uint64_t most = 0;
  bool too_large = false;
};

std::size_t take_bytes(char* data, std::size_t, std::size_t count, void* into) {
  auto& transfer = *static_cast<Transfer*>(into);
  if (count > transfer.most - transfer.bytes.size()) {
    transfer.too_large = true;
    return 0;  // Ends the transfer.
  }
  const auto* const first = reinterpret_cast<const std::byte*>(data);
  transfer.bytes.insert(transfer.bytes.end(), first, first + count);
  return count;
}

// A connection that is used again; one thread at a time.
struct Handle {
  Handle() : curl(curl_easy_init()) {}
  ~Handle() { curl_easy_cleanup(curl); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  CURL* curl;
};

class HttpStore : public ObjectStore {
 public:
  HttpStore(std::string base, bool is_s3) : base_(std::move(base)) {
    static std::once_flag once;
    std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
    if (!is_s3) return;
    const std::string key = environment("AWS_ACCESS_KEY_ID");
    const std::string secret = environment("AWS_SECRET_ACCESS_KEY");
    if (key.empty() || secret.empty()) return;
    user_ = key + ":" + secret;
    std::string region = environment("AWS_REGION");
    if (region.empty()) region = environment("AWS_DEFAULT_REGION");
    sigv4_ = "aws:amz:" + (region.empty() ? "us-east-1" : region) + ":s3";
    session_ = environment("AWS_SESSION_TOKEN");
  }

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    return fetched(key, {}, most);
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    if (length == 0) return std::vector<std::byte>();
    const std::string range =
        offset == kFromEnd ? "-" + std::to_string(length)
                           : std::to_string(offset) + "-" + std::to_string(offset + length - 1);
    return fetched(key, range, length);
  }

  [[nodiscard]] fs::path place(const std::string& key) const override { return base_ + key; }
  [[nodiscard]] std::size_t parallel_requests() const override { return kParallelRequests; }

 private:
  std::optional<std::vector<std::byte>> fetched(const std::string& key, const std::string& range,
                                                std::uint64_t most) {
    const std::string address = base_ + key;
    std::string problem;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      if (attempt > 0) std::this_thread::sleep_for(std::chrono::milliseconds(100 << (2 * attempt)));
      Transfer transfer{.bytes = {}, .most = most};
      std::unique_ptr<Handle> handle = idle_handle();
      long status = 0;
      const CURLcode code = perform(handle->curl, address, range, transfer, status);
      give_back(std::move(handle));
      if (transfer.too_large) {
        fail_reading(address,
                     "it has more than the " + std::to_string(most) + " bytes that it may have" +
                         (range.empty() ? "" : ", or the server does not serve ranges"),
                     "Check that it belongs to this array");
      }
      const long whole = range.empty() ? 200 : 206;
      if (code == CURLE_OK && status == whole) return std::move(transfer.bytes);
      if (code == CURLE_OK && status == 200) {
        fail_reading(address, "the server does not serve ranges",
                     "Use one that does, or a copy on this machine");
      }
      // What buckets say of objects that are not there, with and without the right to list them.
      const bool missing = status == 404 || status == 410 || status == 403;
      if (code == CURLE_OK && missing) return std::nullopt;
      problem = code == CURLE_OK ? "the server answers with status " + std::to_string(status)
                                 : std::string(curl_easy_strerror(code));
      const bool passing = code != CURLE_OK ? code != CURLE_UNSUPPORTED_PROTOCOL &&
                                                  code != CURLE_PEER_FAILED_VERIFICATION
                                            : status == 429 || status >= 500;
      if (!passing) break;
    }
    fail_reading(address, problem, "Check the address, the network and the credentials");
  }

  CURLcode perform(CURL* curl, const std::string& address, const std::string& range,
                   Transfer& transfer, long& status) {
    curl_easy_reset(curl);
    curl_easy_setopt(curl, CURLOPT_URL, address.c_str());
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(curl, CURLOPT_MAXREDIRS, 5L);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, kConnectSeconds);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, kStalledSeconds);
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "multitetra");
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &take_bytes);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &transfer);
    if (!range.empty()) curl_easy_setopt(curl, CURLOPT_RANGE, range.c_str());
    curl_slist* headers = nullptr;
    if (!user_.empty()) {
      curl_easy_setopt(curl, CURLOPT_USERPWD, user_.c_str());
      curl_easy_setopt(curl, CURLOPT_AWS_SIGV4, sigv4_.c_str());
      if (!session_.empty()) {
        headers = curl_slist_append(headers, ("x-amz-security-token: " + session_).c_str());
        curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
      }
    }
    const CURLcode code = curl_easy_perform(curl);
    curl_slist_free_all(headers);
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
    return code;
  }

  std::unique_ptr<Handle> idle_handle() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<Handle>();
    std::unique_ptr<Handle> handle = std::move(idle_.back());
    idle_.pop_back();
    return handle;
  }
  void give_back(std::unique_ptr<Handle> handle) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(handle));
  }

  std::string base_;  // Ends in '/'.
  std::string user_;
  std::string sigv4_;
  std::string session_;
  std::mutex mutex_;  // Guards idle_.
  std::vector<std::unique_ptr<Handle>> idle_;
};

}  // namespace

bool is_address(std::string_view text) {
  return text.starts_with("http://") || text.starts_with("https://") || text.starts_with("s3://");
}

std::unique_ptr<ObjectStore> http_store(const std::string& address) {
  std::string base = address;
  const bool is_s3 = address.starts_with("s3://");
  if (is_s3) {
    const std::string rest = address.substr(5);
    const std::string bucket = rest.substr(0, rest.find('/'));
    const std::string prefix = rest.substr(std::min(bucket.size() + 1, rest.size()));
    if (bucket.empty()) fail_reading(address, "it names no bucket", "Write s3://bucket/path");
    std::string endpoint = environment("AWS_ENDPOINT_URL");
    while (endpoint.ends_with('/')) endpoint.pop_back();
    std::string region = environment("AWS_REGION");
    if (region.empty()) region = environment("AWS_DEFAULT_REGION");
    base = endpoint.empty()
               ? "https://" + bucket + ".s3." + (region.empty() ? "us-east-1" : region) +
                     ".amazonaws.com/" + prefix
               : endpoint + "/" + bucket + "/" + prefix;
  }
  if (!base.ends_with('/')) base += '/';
  return std::make_unique<HttpStore>(std::move(base), is_s3);
}

}  // namespace multitetra

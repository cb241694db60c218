#include "server/store/http_store.hpp"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

// S3 wants a signed request to tell the digest of its content; this is SHA-256 of nothing. Newer
// versions of libcurl say it by themselves.
constexpr const char* kNothingIsSent =
    "x-amz-content-sha256: e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

std::string aws_region() {
  std::string region = environment("AWS_REGION");
  if (region.empty()) region = environment("AWS_DEFAULT_REGION");
  return region.empty() ? "us-east-1" : region;
}

// What is asked for: the whole object, or a part of it.
struct Wanted {
  bool is_whole = true;
  std::uint64_t offset = 0;  // Or kFromEnd.
  std::uint64_t length = 0;

  [[nodiscard]] std::string header() const {
    if (is_whole) return {};
    if (offset == ObjectStore::kFromEnd) return "-" + std::to_string(length);
    return std::to_string(offset) + "-" + std::to_string(offset + length - 1);
  }
};

// "bytes 0-99/1234"; nullopt when it is no such thing.
struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::optional<std::uint64_t> total;

  static std::optional<ContentRange> from(std::string_view text) {
    constexpr std::string_view kUnit = "bytes ";
    if (!text.starts_with(kUnit)) return std::nullopt;
    text.remove_prefix(kUnit.size());
    ContentRange range;
    const auto number = [&text](std::uint64_t& into, char end) {
      const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), into);
      if (error != std::errc()) return false;
      text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
      if (end == '\0') return text.empty();
      if (!text.starts_with(end)) return false;
      text.remove_prefix(1);
      return true;
    };
    if (!number(range.first, '-') || !number(range.last, '/')) return std::nullopt;
    if (text != "*" && !number(range.total.emplace(), '\0')) return std::nullopt;
    return range.first <= range.last ? std::optional(range) : std::nullopt;
  }

  // Whether it is what was wanted, cut off at the object's end at most.
  [[nodiscard]] bool is(const Wanted& wanted) const {
    if (wanted.offset == ObjectStore::kFromEnd) {
      return total && last + 1 == *total && last - first + 1 == std::min(wanted.length, *total);
    }
    const std::uint64_t end = wanted.offset + wanted.length;
    return first == wanted.offset && last < end && (last + 1 == end || total == last + 1);
  }
};

// What has come of a request so far.
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

// An address taken apart by libcurl.
class Url {
 public:
  explicit Url(const std::string& text)
      : url_(curl_url(), &curl_url_cleanup),
        is_valid_(curl_url_set(url_.get(), CURLUPART_URL, text.c_str(), 0) == CURLUE_OK) {}

  [[nodiscard]] bool is_valid() const { return is_valid_; }
  // Empty where there is none.
  [[nodiscard]] std::string part(CURLUPart which, unsigned flags = 0) const {
    char* text = nullptr;
    if (curl_url_get(url_.get(), which, &text, flags) != CURLUE_OK) return {};
    std::string result(text);
    curl_free(text);
    return result;
  }
  [[nodiscard]] std::string scheme() const { return part(CURLUPART_SCHEME); }
  [[nodiscard]] std::string host() const { return lower_case(part(CURLUPART_HOST)); }
  [[nodiscard]] std::string port() const { return part(CURLUPART_PORT, CURLU_DEFAULT_PORT); }

  void leave_out(CURLUPart which) { curl_url_set(url_.get(), which, nullptr, 0); }

 private:
  std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url_;
  bool is_valid_;
};

// Whether credentials for `from` are for `to` as well: the same port of the same host, or its
// https.
bool is_same_host(const Url& from, const Url& to) {
  if (from.host() != to.host() || from.host().empty()) return false;
  if (from.scheme() == to.scheme()) return from.port() == to.port();
  return from.scheme() == "http" && to.scheme() == "https";
}

// A key as a part of an address: what is no plain character of a path is escaped, so that names
// from metadata stay names.
std::string escaped_key(std::string_view key) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  constexpr std::string_view kPlain = "-._~/!$&'()*+,;=:@";
  std::string text;
  for (const char c : key) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || kPlain.find(c) != std::string_view::npos;
    const auto byte = static_cast<unsigned char>(c);
    if (is_plain) {
      text += c;
    } else {
      text += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return text;
}

// What one try says.
struct Outcome {
  enum class Kind { kDone, kMissing, kRefused, kTryAgain, kFailed };
  Kind kind = Kind::kFailed;
  std::string problem = {};
  std::string remedy = "Check the address, the network and the credentials";
  milliseconds pause{0};  // What the server asks for.
};

class HttpStore : public ObjectStore {
 public:
  HttpStore(std::string base, bool is_s3, const HttpStoreOptions& options)
      : base_(std::move(base)), options_(options), free_(options.connections) {
    static std::once_flag once;
    std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
    Url url(base_);
    if (!url.is_valid()) throw StoreError(base_, "it is no address", "Write http://host/path");
    user_ = url.part(CURLUPART_USER, CURLU_URLDECODE);
    if (!user_.empty()) user_ += ":" + url.part(CURLUPART_PASSWORD, CURLU_URLDECODE);
    url.leave_out(CURLUPART_USER);
    url.leave_out(CURLUPART_PASSWORD);
    base_ = url.part(CURLUPART_URL);
    if (!is_s3) return;
    const std::string key = environment("AWS_ACCESS_KEY_ID");
    const std::string secret = environment("AWS_SECRET_ACCESS_KEY");
    if (key.empty() || secret.empty()) return;
    user_ = key + ":" + secret;
    sigv4_ = "aws:amz:" + aws_region() + ":s3";
    session_ = environment("AWS_SESSION_TOKEN");
  }

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    return fetched(key, {}, most);
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    if (length == 0) return std::vector<std::byte>();
    return fetched(key, {.is_whole = false, .offset = offset, .length = length}, length);
  }

  [[nodiscard]] fs::path place(const std::string& key) const override { return base_ + key; }
  [[nodiscard]] std::size_t parallel_requests() const override { return options_.connections; }

 private:
  std::optional<std::vector<std::byte>> fetched(const std::string& key, const Wanted& wanted,
                                                std::uint64_t most) {
    const fs::path inside(key);
    const bool leads_out = std::find(inside.begin(), inside.end(), "..") != inside.end();
    if (leads_out && !options_.follow) {
      throw StoreError(base_, "it names '" + key + "', which leads out of the address",
                       "Correct its metadata, or allow it with --follow if you trust them");
    }
    const std::string address = base_ + escaped_key(key);
    fail_while_resting(address);
    const Clock::time_point deadline = Clock::now() + options_.deadline;
    milliseconds pause = options_.first_pause;
    Outcome outcome;
    for (int attempt = 0; attempt < options_.tries; ++attempt) {
      if (attempt > 0) {
        const milliseconds wait =
            std::min(std::max(outcome.pause, shaken(pause)), options_.longest_pause);
        if (Clock::now() + wait >= deadline) break;
        std::this_thread::sleep_for(wait);
        if (options_.tries_again) options_.tries_again();
        pause *= 2;
      }
      Transfer transfer{.bytes = {}, .most = most};
      outcome = attempted(address, wanted, deadline, transfer);
      if (outcome.kind == Outcome::Kind::kDone) return std::move(transfer.bytes);
      if (outcome.kind == Outcome::Kind::kMissing) return std::nullopt;
      if (outcome.kind == Outcome::Kind::kFailed) break;
    }
    if (outcome.kind == Outcome::Kind::kTryAgain) rest(outcome.problem);
    if (outcome.kind == Outcome::Kind::kRefused) {
      throw StoreRefusal(address, outcome.problem, outcome.remedy);
    }
    throw StoreError(address, outcome.problem, outcome.remedy);
  }

  void fail_while_resting(const std::string& address) {
    const std::lock_guard lock(mutex_);
    if (Clock::now() >= rests_until_) return;
    throw StoreError(address, "its store failed a moment ago: " + rests_since_,
                     "It is tried again soon");
  }
  void rest(const std::string& problem) {
    const std::lock_guard lock(mutex_);
    rests_until_ = Clock::now() + options_.rest_after_failure;
    rests_since_ = problem;
  }

  Outcome attempted(const std::string& address, const Wanted& wanted, Clock::time_point deadline,
                    Transfer& transfer) {
    std::unique_ptr<Handle> handle = idle_handle();
    const Outcome outcome =
        attempted_along_redirects(handle->curl, address, wanted, deadline, transfer);
    give_back(std::move(handle));
    return outcome;
  }

  Outcome attempted_along_redirects(CURL* curl, std::string address, const Wanted& wanted,
                                    Clock::time_point deadline, Transfer& transfer) const {
    constexpr int kMostRedirects = 5;
    for (int redirects = 0;; ++redirects) {
      const CURLcode code = perform(curl, address, wanted, deadline, transfer);
      char* next = nullptr;
      if (code == CURLE_OK) curl_easy_getinfo(curl, CURLINFO_REDIRECT_URL, &next);
      if (next == nullptr) return judged(curl, code, wanted, transfer);
      const std::string to(next);
      if (const auto refusal = refused_redirect(address, to)) return *refusal;
      if (redirects == kMostRedirects) {
        return {.kind = Outcome::Kind::kFailed, .problem = "it is redirected again and again"};
      }
      address = to;
      transfer.bytes.clear();
    }
  }

  [[nodiscard]] std::optional<Outcome> refused_redirect(const std::string& from,
                                                        const std::string& to) const {
    const Url before(from);
    const Url after(to);
    const std::string problem = "the server redirects to '" + to + "'";
    if (!after.is_valid() || (after.scheme() != "http" && after.scheme() != "https") ||
        (before.scheme() == "https" && after.scheme() == "http")) {
      return Outcome{.problem = problem + ", which is no https", .remedy = "Check the address"};
    }
    if (options_.follow || is_same_host(before, after)) return std::nullopt;
    return Outcome{
        .problem = problem + ", which is another host",
        .remedy = "Give that address, or allow it with --follow if you trust the server"};
  }

  CURLcode perform(CURL* curl, const std::string& address, const Wanted& wanted,
                   Clock::time_point deadline, Transfer& transfer) const {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - Clock::now()).count();
    curl_easy_reset(curl);
    curl_easy_setopt(curl, CURLOPT_URL, address.c_str());
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, static_cast<long>(options_.connecting.count()));
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 256L);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, static_cast<long>(options_.stalled.count()));
    curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, static_cast<long>(std::max<long>(1, left)));
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "multitetra");
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &take_bytes);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &transfer);
    const std::string range = wanted.header();
    if (!range.empty()) curl_easy_setopt(curl, CURLOPT_RANGE, range.c_str());
    curl_slist* headers = nullptr;
    const bool is_trusted = !user_.empty() && is_same_host(Url(base_), Url(address));
    if (is_trusted) curl_easy_setopt(curl, CURLOPT_USERPWD, user_.c_str());
    if (is_trusted && !sigv4_.empty()) {
      curl_easy_setopt(curl, CURLOPT_AWS_SIGV4, sigv4_.c_str());
      headers = curl_slist_append(headers, kNothingIsSent);
      if (!session_.empty()) {
        headers = curl_slist_append(headers, ("x-amz-security-token: " + session_).c_str());
      }
      curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
    }
    const CURLcode code = curl_easy_perform(curl);
    curl_slist_free_all(headers);
    return code;
  }

  static Outcome judged(CURL* curl, CURLcode code, const Wanted& wanted, const Transfer& transfer) {
    using Kind = Outcome::Kind;
    if (transfer.too_large) {
      return {.kind = Kind::kFailed,
              .problem = "it has more than the " + std::to_string(transfer.most) +
                         " bytes that it may have" +
                         (wanted.is_whole ? "" : ", or the server does not serve ranges"),
              .remedy = "Check that it belongs there"};
    }
    if (code != CURLE_OK) {
      const bool stays = code == CURLE_UNSUPPORTED_PROTOCOL || code == CURLE_URL_MALFORMAT ||
                         code == CURLE_PEER_FAILED_VERIFICATION || code == CURLE_TOO_MANY_REDIRECTS;
      return {.kind = stays ? Kind::kFailed : Kind::kTryAgain, .problem = curl_easy_strerror(code)};
    }
    long status = 0;
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
    if (wanted.is_whole && status == 200) return {.kind = Kind::kDone};
    if (!wanted.is_whole && status == 206) return judged_part(curl, wanted, transfer);
    if (!wanted.is_whole && status == 200) {
      return {.kind = Kind::kFailed,
              .problem = "the server does not serve ranges",
              .remedy = "Use one that does, or a copy on this machine"};
    }
    if (status == 404 || status == 410) return {.kind = Kind::kMissing};
    if (status == 401 || status == 403) {
      return {.kind = Kind::kRefused,
              .problem = "the server refuses it with status " + std::to_string(status),
              .remedy =
                  "Check the credentials; a bucket says so of objects that are missing, too, "
                  "unless it may be listed"};
    }
    curl_off_t seconds = 0;
    curl_easy_getinfo(curl, CURLINFO_RETRY_AFTER, &seconds);
    const bool passes = status == 429 || status >= 500;
    return {.kind = passes ? Kind::kTryAgain : Kind::kFailed,
            .problem = "the server answers with status " + std::to_string(status),
            .pause = milliseconds(1000 * std::clamp<curl_off_t>(seconds, 0, 3600))};
  }

  static Outcome judged_part(CURL* curl, const Wanted& wanted, const Transfer& transfer) {
    curl_header* header = nullptr;
    const bool is_told =
        curl_easy_header(curl, "Content-Range", 0, CURLH_HEADER, -1, &header) == CURLHE_OK;
    const auto range = is_told ? ContentRange::from(header->value) : std::nullopt;
    if (range && range->is(wanted) && transfer.bytes.size() == range->last - range->first + 1) {
      return {.kind = Outcome::Kind::kDone};
    }
    return {.kind = Outcome::Kind::kTryAgain,
            .problem = "asked for bytes " + wanted.header() + ", the server sends " +
                       std::to_string(transfer.bytes.size()) + " bytes as \"" +
                       (is_told ? std::string(header->value) : std::string()) + "\"",
            .remedy = "Use a server that serves ranges as HTTP wants it"};
  }

  // Between a half of it and all of it: many who failed together do not come again together.
  static milliseconds shaken(milliseconds pause) {
    thread_local std::minstd_rand random(std::random_device{}());
    return milliseconds(std::uniform_int_distribution(pause.count() / 2, pause.count())(random));
  }

  std::unique_ptr<Handle> idle_handle() {
    std::unique_lock lock(mutex_);
    is_free_.wait(lock, [this] { return free_ > 0; });
    --free_;
    if (idle_.empty()) return std::make_unique<Handle>();
    std::unique_ptr<Handle> handle = std::move(idle_.back());
    idle_.pop_back();
    return handle;
  }
  void give_back(std::unique_ptr<Handle> handle) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(handle));
    ++free_;
    is_free_.notify_one();
  }

  std::string base_;  // Ends in '/'.
  HttpStoreOptions options_;
  std::string user_;  // "user:password", or the key and secret of S3; empty: none.
  std::string sigv4_;
  std::string session_;
  std::mutex mutex_;  // Guards what follows.
  std::condition_variable is_free_;
  std::size_t free_;  // Connections that may be used besides.
  std::vector<std::unique_ptr<Handle>> idle_;
  Clock::time_point rests_until_;
  std::string rests_since_;  // What was wrong then.
};

}  // namespace

bool is_address(std::string_view text) {
  return text.starts_with("http://") || text.starts_with("https://") || text.starts_with("s3://");
}

std::unique_ptr<ObjectStore> http_store(const std::string& address,
                                        const HttpStoreOptions& options) {
  std::string base = address;
  const bool is_s3 = address.starts_with("s3://");
  if (is_s3) {
    const std::string rest = address.substr(5);
    const std::string bucket = rest.substr(0, rest.find('/'));
    const std::string prefix = rest.substr(std::min(bucket.size() + 1, rest.size()));
    if (bucket.empty()) throw StoreError(address, "it names no bucket", "Write s3://bucket/path");
    std::string endpoint = environment("AWS_ENDPOINT_URL");
    while (endpoint.ends_with('/')) endpoint.pop_back();
    base = endpoint.empty()
               ? "https://" + bucket + ".s3." + aws_region() + ".amazonaws.com/" + prefix
               : endpoint + "/" + bucket + "/" + prefix;
  }
  if (!base.ends_with('/')) base += '/';
  return std::make_unique<HttpStore>(std::move(base), is_s3, options);
}

}  // namespace multitetra

#include "server/store/detail/store_client.hpp"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <random>
#include <thread>
#include <utility>

#include "server/store/detail/content_range.hpp"
#include "server/store/detail/curl_url.hpp"
#include "server/store/detail/redirects.hpp"
#include "server/store/detail/request_signature.hpp"
#include "server/store/detail/resolved_url.hpp"
#include "server/store/store_error.hpp"

namespace multitetra {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

std::string range_text(const StoreRange& range) {
  if (range.first == StoreRange::kFromEnd) return "-" + std::to_string(range.length);
  return std::to_string(range.first) + "-" + std::to_string(range.first + range.length - 1);
}

// The response body received so far.
struct Transfer {
  std::vector<std::byte>& bytes;
  std::uint64_t most = 0;
  bool too_large = false;
};

std::size_t take_bytes(char* data, std::size_t, std::size_t count, void* into) {
  auto& transfer = *static_cast<Transfer*>(into);
  if (count > transfer.most - transfer.bytes.size()) {
    transfer.too_large = true;
    return 0;  // Aborts the transfer.
  }
  const auto* const first = reinterpret_cast<const std::byte*>(data);
  transfer.bytes.insert(transfer.bytes.end(), first, first + count);
  return count;
}

std::string header_of(CURL* curl, const char* name) {
  curl_header* header = nullptr;
  if (curl_easy_header(curl, name, 0, CURLH_HEADER, -1, &header) != CURLHE_OK) return {};
  return header->value;
}

// Returns a random pause between half of `pause` and all of it, so that clients that failed
// together do not retry together.
milliseconds jittered(milliseconds pause) {
  thread_local std::minstd_rand random(std::random_device{}());
  return milliseconds(std::uniform_int_distribution(pause.count() / 2, pause.count())(random));
}

}  // namespace

// The credentials of a request; empty if none are needed.
struct StoreClient::Credentials {
  std::string user;  // "user:password"
  SigningKey key = {};
};

// A persistent connection, used by one thread at a time.
struct StoreClient::Handle {
  Handle() : curl(curl_easy_init()) {}
  ~Handle() { curl_easy_cleanup(curl); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  CURLcode perform(const StoreRequest& request, const HttpStoreOptions& options,
                   const Credentials& credentials, milliseconds remaining,
                   Transfer& transfer) const;

  CURL* curl;
};

// The outcome of one attempt.
struct StoreClient::Outcome {
  enum class Kind { kDone, kTryAgain, kFailed };
  Kind kind = Kind::kFailed;
  std::string problem = {};
  std::string remedy = "Check the address, the network and the credentials";
  milliseconds pause{0};  // Requested by the server.
  bool has_stalled = false;

  static Outcome of(CURL* curl, CURLcode code, const StoreRequest& request,
                    const Transfer& transfer, HttpAnswer& answer);
  static Outcome of_part(CURL* curl, const StoreRequest& request, HttpAnswer& answer);
};

StoreClient::StoreClient(bool signs_for_s3, const HttpStoreOptions& options)
    : options_(options), free_(options.connections) {
  static std::once_flag once;
  std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
  if (!signs_for_s3) return;
  const std::string key = environment("AWS_ACCESS_KEY_ID");
  const std::string secret = environment("AWS_SECRET_ACCESS_KEY");
  if (key.empty() || secret.empty()) return;
  key_ = {.id = key,
          .secret = secret,
          .session = environment("AWS_SESSION_TOKEN"),
          .region = aws_region()};
}

StoreClient::~StoreClient() = default;

HttpAnswer StoreClient::send(const StoreRequest& request) {
  check_cooldown(request.address);
  const Clock::time_point deadline = Clock::now() + options_.deadline;
  const auto remaining = [&] {
    return std::chrono::duration_cast<milliseconds>(deadline - Clock::now());
  };
  milliseconds pause = options_.first_pause;
  constexpr int kMaxStalls = 2;
  int stalls = 0;
  Outcome outcome;
  for (int attempt = 0; attempt < options_.max_attempts; ++attempt) {
    if (attempt > 0) {
      const milliseconds wait =
          std::min(std::max(outcome.pause, jittered(pause)), options_.longest_pause);
      if (wait >= remaining()) break;
      std::this_thread::sleep_for(wait);
      if (options_.on_retry) options_.on_retry();
      pause *= 2;
    }
    HttpAnswer answer;
    outcome = try_request(request, remaining(), answer);
    if (outcome.kind == Outcome::Kind::kDone) return answer;
    if (outcome.kind == Outcome::Kind::kFailed) break;
    // A stalled attempt has taken its full time, so a server that stalls repeatedly is given up.
    if (outcome.has_stalled && ++stalls == kMaxStalls) break;
  }
  if (outcome.kind == Outcome::Kind::kTryAgain) start_cooldown(outcome.problem);
  throw StoreError(request.address, outcome.problem, outcome.remedy);
}

void StoreClient::check_cooldown(const std::string& address) {
  const std::lock_guard lock(mutex_);
  if (Clock::now() >= cooldown_until_) return;
  throw StoreError(address, "the store failed recently: " + cooldown_reason_,
                   "Retry in a few seconds");
}

void StoreClient::start_cooldown(const std::string& problem) {
  const std::lock_guard lock(mutex_);
  cooldown_until_ = Clock::now() + options_.cooldown_after_failure;
  cooldown_reason_ = problem;
}

StoreClient::Outcome StoreClient::try_request(const StoreRequest& request, milliseconds remaining,
                                              HttpAnswer& answer) {
  std::unique_ptr<Handle> handle = idle_handle();
  const Outcome outcome = try_with_redirects(*handle, request, remaining, answer);
  return_handle(std::move(handle));
  return outcome;
}

StoreClient::Outcome StoreClient::try_with_redirects(Handle& handle, const StoreRequest& request,
                                                     milliseconds remaining, HttpAnswer& answer) {
  constexpr int kMaxRedirects = 5;
  const Clock::time_point deadline = Clock::now() + remaining;
  CurlUrl url(request.address);
  if (!url.is_valid())
    return {.problem = "it is not an address", .remedy = "Write http://host/path"};
  const Credentials credentials{.user = key_.id.empty() ? url.user() : "", .key = key_};
  url.remove_user();
  StoreRequest next = request;
  next.address = url.part(CURLUPART_URL);
  for (int redirects = 0;; ++redirects) {
    const bool is_trusted = is_same_host(url, CurlUrl(next.address));
    Transfer transfer{.bytes = answer.bytes, .most = request.most};
    const auto rest = std::chrono::duration_cast<milliseconds>(deadline - Clock::now());
    const CURLcode code =
        handle.perform(next, options_, is_trusted ? credentials : Credentials(), rest, transfer);
    char* found = nullptr;
    if (code == CURLE_OK) curl_easy_getinfo(handle.curl, CURLINFO_REDIRECT_URL, &found);
    if (found == nullptr) return Outcome::of(handle.curl, code, next, transfer, answer);
    const std::string to(found);
    if (const auto refused = refused_redirect(next.address, to, options_.allow_other_hosts)) {
      return {.problem = refused->problem, .remedy = refused->remedy};
    }
    if (redirects == kMaxRedirects) return {.problem = "there are too many redirects"};
    next.address = to;
    answer.bytes.clear();
  }
}

CURLcode StoreClient::Handle::perform(const StoreRequest& request, const HttpStoreOptions& options,
                                      const Credentials& credentials, milliseconds remaining,
                                      Transfer& transfer) const {
  curl_easy_reset(curl);
  curl_easy_setopt(curl, CURLOPT_URL, request.address.c_str());
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT,
                   static_cast<long>(options.connect_timeout.count()));
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 256L);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, static_cast<long>(options.stall_timeout.count()));
  curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS,
                   static_cast<long>(std::max<long>(1, remaining.count())));
  curl_easy_setopt(curl, CURLOPT_USERAGENT, "multitetra");
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &take_bytes);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &transfer);
  const std::string range = request.range ? range_text(*request.range) : std::string();
  if (!range.empty()) curl_easy_setopt(curl, CURLOPT_RANGE, range.c_str());
  curl_slist* headers = nullptr;
  const auto add = [&](const std::string& header) {
    headers = curl_slist_append(headers, header.c_str());
  };
  if (request.method != "GET") {
    curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE,
                     static_cast<curl_off_t>(request.body.size()));
    curl_easy_setopt(
        curl, CURLOPT_POSTFIELDS,
        request.body.empty() ? "" : reinterpret_cast<const char*>(request.body.data()));
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, request.method.c_str());
    add("Content-Type: application/octet-stream");
  }
  for (const std::string& header : request.headers) add(header);
  if (!credentials.user.empty()) curl_easy_setopt(curl, CURLOPT_USERPWD, credentials.user.c_str());
  if (!credentials.key.id.empty()) {
    const auto now = std::chrono::system_clock::now();
    for (const std::string& header :
         signature_headers(credentials.key, request.method, request.address, request.body, now)) {
      add(header);
    }
  }
  curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);
  const CURLcode code = curl_easy_perform(curl);
  curl_slist_free_all(headers);
  return code;
}

StoreClient::Outcome StoreClient::Outcome::of(CURL* curl, CURLcode code,
                                              const StoreRequest& request, const Transfer& transfer,
                                              HttpAnswer& answer) {
  if (transfer.too_large) {
    return {.problem = "it is larger than the limit of " + std::to_string(transfer.most) +
                       " bytes" + (request.range ? ", or the server does not serve ranges" : ""),
            .remedy = "Check that it is the right file"};
  }
  if (code != CURLE_OK) {
    const bool stays = code == CURLE_UNSUPPORTED_PROTOCOL || code == CURLE_URL_MALFORMAT ||
                       code == CURLE_PEER_FAILED_VERIFICATION || code == CURLE_TOO_MANY_REDIRECTS;
    return {.kind = stays ? Kind::kFailed : Kind::kTryAgain,
            .problem = curl_easy_strerror(code),
            .has_stalled = code == CURLE_OPERATION_TIMEDOUT};
  }
  curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &answer.status);
  answer.etag = header_of(curl, "ETag");
  answer.last_modified = header_of(curl, "Last-Modified");
  if (answer.status == 429 || answer.status >= 500) {
    curl_off_t seconds = 0;
    curl_easy_getinfo(curl, CURLINFO_RETRY_AFTER, &seconds);
    return {.kind = Kind::kTryAgain,
            .problem = "the server returned status " + std::to_string(answer.status),
            .pause = milliseconds(1000 * std::clamp<curl_off_t>(seconds, 0, 3600))};
  }
  if (request.range && answer.status == 206) return of_part(curl, request, answer);
  if (request.range && answer.is_good()) {
    return {.problem = "the server does not serve ranges",
            .remedy = "Use a server that does, or a local copy"};
  }
  return {.kind = Kind::kDone};
}

StoreClient::Outcome StoreClient::Outcome::of_part(CURL* curl, const StoreRequest& request,
                                                   HttpAnswer& answer) {
  const std::string text = header_of(curl, "Content-Range");
  const auto range = ContentRange::from(text);
  if (range && range->matches(*request.range) &&
      answer.bytes.size() == range->last - range->first + 1) {
    answer.total = range->total.value_or(0);
    return {.kind = Kind::kDone};
  }
  return {.kind = Kind::kTryAgain,
          .problem = "requested bytes " + range_text(*request.range) + ", but the server sent " +
                     std::to_string(answer.bytes.size()) + " bytes as \"" + text + "\"",
          .remedy = "Use a server that serves byte ranges as the HTTP standard defines them"};
}

std::unique_ptr<StoreClient::Handle> StoreClient::idle_handle() {
  std::unique_lock lock(mutex_);
  is_free_.wait(lock, [this] { return free_ > 0; });
  --free_;
  if (idle_.empty()) return std::make_unique<Handle>();
  std::unique_ptr<Handle> handle = std::move(idle_.back());
  idle_.pop_back();
  return handle;
}

void StoreClient::return_handle(std::unique_ptr<Handle> handle) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(handle));
  ++free_;
  is_free_.notify_one();
}

}  // namespace multitetra

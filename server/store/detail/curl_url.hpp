// A URL, parsed by libcurl.
#pragma once

#include <curl/curl.h>

#include <memory>
#include <string>

#include "common/base/text.hpp"

namespace multitetra {

class CurlUrl {
 public:
  explicit CurlUrl(const std::string& text)
      : url_(curl_url(), &curl_url_cleanup),
        is_valid_(curl_url_set(url_.get(), CURLUPART_URL, text.c_str(), 0) == CURLUE_OK) {}

  [[nodiscard]] bool is_valid() const { return is_valid_; }
  // Empty if the part is absent.
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
  // Returns "user:password", or nothing.
  [[nodiscard]] std::string user() const {
    const std::string name = part(CURLUPART_USER, CURLU_URLDECODE);
    return name.empty() ? name : name + ":" + part(CURLUPART_PASSWORD, CURLU_URLDECODE);
  }
  void remove_user() {
    curl_url_set(url_.get(), CURLUPART_USER, nullptr, 0);
    curl_url_set(url_.get(), CURLUPART_PASSWORD, nullptr, 0);
  }

 private:
  std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> url_;
  bool is_valid_;
};

// Returns whether credentials for `from` may be sent to `to`: the same host and port, or its https.
[[nodiscard]] inline bool is_same_host(const CurlUrl& from, const CurlUrl& to) {
  if (from.host() != to.host() || from.host().empty()) return false;
  if (from.scheme() == to.scheme()) return from.port() == to.port();
  return from.scheme() == "http" && to.scheme() == "https";
}

}  // namespace multitetra

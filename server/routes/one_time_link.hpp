// A link that leads to a page once. Programs are started with addresses that every user of the
// machine can read; a token in such an address would be known to all.
#pragma once

#include <atomic>
#include <string>
#include <string_view>
#include <utility>

namespace multitetra {

class OneTimeLink {
 public:
  // The path kOpenPath + `code` leads to the page with this fragment, such as "#token=...".
  // `code` cannot be guessed.
  OneTimeLink(std::string code, std::string fragment)
      : code_(std::move(code)), fragment_(std::move(fragment)) {}

  [[nodiscard]] const std::string& code() const { return code_; }
  // Returns the fragment for the first request with the code, null for all others.
  [[nodiscard]] const std::string* take(std::string_view code) {
    return code == code_ && !is_used_.exchange(true) ? &fragment_ : nullptr;
  }

 private:
  const std::string code_;
  const std::string fragment_;
  std::atomic<bool> is_used_ = false;
};

inline constexpr std::string_view kOpenPath = "/open/";

}  // namespace multitetra

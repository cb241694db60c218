// Which redirects are followed.
#pragma once

#include <optional>
#include <string>

namespace multitetra {

// Why a redirect is not followed.
struct RefusedRedirect {
  std::string problem;
  std::string remedy;
};

// nullopt for what is followed: http or https of the same host, or of any with `follow`, and never
// from https to http.
[[nodiscard]] std::optional<RefusedRedirect> refused_redirect(const std::string& from,
                                                              const std::string& to, bool follow);

}  // namespace multitetra

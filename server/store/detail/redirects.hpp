// The policy for redirects.
#pragma once

#include <optional>
#include <string>

namespace multitetra {

// The reason for not following a redirect.
struct RefusedRedirect {
  std::string problem;
  std::string remedy;
};

// Returns nullopt for permitted redirects: http or https on the same host, or with
// `allow_other_hosts` on any host, but never from https to http.
[[nodiscard]] std::optional<RefusedRedirect> refused_redirect(const std::string& from,
                                                              const std::string& to,
                                                              bool allow_other_hosts);

}  // namespace multitetra

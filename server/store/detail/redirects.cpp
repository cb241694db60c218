#include "server/store/detail/redirects.hpp"

#include "common/base/address_text.hpp"
#include "server/store/detail/curl_url.hpp"

namespace multitetra {

std::optional<RefusedRedirect> refused_redirect(const std::string& from, const std::string& to,
                                                bool allow_other_hosts) {
  const CurlUrl before(from);
  const CurlUrl after(to);
  const std::string problem = "the server redirects to '" + without_password(to) + "'";
  if (!after.is_valid() || (after.scheme() != "http" && after.scheme() != "https") ||
      (before.scheme() == "https" && after.scheme() == "http")) {
    return RefusedRedirect{.problem = problem + ", which is no https",
                           .remedy = "Check the address"};
  }
  if (allow_other_hosts || is_same_host(before, after)) return std::nullopt;
  return RefusedRedirect{.problem = problem + ", which is another host",
                         .remedy = "Give that address; `prepare --follow` allows it for volumes"};
}

}  // namespace multitetra

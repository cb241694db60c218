#include "server/operations/open_files.hpp"

#include <sys/resource.h>

#include <algorithm>

namespace multitetra {

std::uint64_t allow_most_open_files() {
  constexpr rlim_t kMaxOpenFiles = 1 << 20;  // No server has that many connections.
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  const rlim_t wanted = std::min(limit.rlim_max, kMaxOpenFiles);
  if (limit.rlim_cur < wanted) {
    const rlimit more = {.rlim_cur = wanted, .rlim_max = limit.rlim_max};
    if (::setrlimit(RLIMIT_NOFILE, &more) == 0) limit = more;
  }
  return limit.rlim_cur;
}

}  // namespace multitetra

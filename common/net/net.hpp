// The one file that includes Boost.Asio: everything that touches a socket, a timer or a coroutine
// includes this instead.
#pragma once

#include <utility>  // Boost 1.74 uses std::exchange in its coroutines without including it.

#if defined(__SANITIZE_THREAD__)
#define BOOST_ASIO_DISABLE_FENCED_BLOCK  // GCC's thread sanitizer does not know fences.
#endif
#include <boost/asio.hpp>

namespace multitetra {

namespace asio = boost::asio;
using boost::asio::ip::tcp;

// co_await operation(use_error(error)): the operation reports its failure in `error` and does not
// throw.
[[nodiscard]] inline auto use_error(boost::system::error_code& error) {
  return asio::redirect_error(asio::use_awaitable, error);
}

}  // namespace multitetra

// Includes Boost.Asio: all code with sockets, timers or coroutines includes this header instead of
// Asio's. Headers that only name an io_context include net_fwd.hpp.
#pragma once

#include <utility>  // Boost 1.74's coroutines use std::exchange without it.

#if defined(__SANITIZE_THREAD__)
#define BOOST_ASIO_DISABLE_FENCED_BLOCK  // GCC's thread sanitizer does not support fences.
#endif
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>

namespace multitetra {

namespace asio = boost::asio;
using boost::asio::ip::tcp;
using boost::system::error_code;

// co_await operation(use_error(error)): reports failures in `error` instead of throwing.
[[nodiscard]] inline auto use_error(error_code& error) {
  return asio::redirect_error(asio::use_awaitable, error);
}

}  // namespace multitetra

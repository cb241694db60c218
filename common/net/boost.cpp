// Compiles the parts of Boost.Asio and Boost.Beast that are not templates.
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <boost/asio/impl/src.hpp>
#include <boost/asio/ssl/impl/src.hpp>
#include <boost/beast/src.hpp>

#include <boost/assert.hpp>

#ifndef NDEBUG

// Called by BOOST_ASSERT in builds with assertions. Ends the program as assert() does, except for
// one assertion of Beast 1.74: a read that waits until the socket has been closed ends, if closing
// times out, with the error of that timeout instead of operation_aborted. Both are correct.
void boost::assertion_failed_msg(const char* expression, const char* message, const char* function,
                                 const char* file, long line) {
  if (std::string_view(expression) == "ec == net::error::operation_aborted") return;
  std::fprintf(stderr, "%s:%ld: %s: Assertion `%s' failed.%s\n", file, line, function, expression,
               message);
  std::abort();
}

void boost::assertion_failed(const char* expression, const char* function, const char* file,
                             long line) {
  assertion_failed_msg(expression, "", function, file, line);
}

#endif

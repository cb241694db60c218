// Work of an HTTP request on threads that are not the connections'.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/result.hpp"
#include "common/net/async_event.hpp"
#include "common/net/coroutines.hpp"
#include "common/net/net.hpp"
#include "server/stream/workers.hpp"

namespace multitetra {

// What `make` gives, which runs on one of the workers, in its turn, and must not throw. The
// executor keeps running until it has come back.
template <typename T>
[[nodiscard]] asio::awaitable<Result<T>> on_workers(Workers& workers, std::string share,
                                                    std::string kind, bool is_long,
                                                    std::function<Result<T>()> make) {
  struct Made {
    explicit Made(asio::any_io_executor executor) : done(std::move(executor)) {}
    std::optional<Result<T>> result;
    AsyncEvent done;
  };
  const auto executor = co_await asio::this_coro::executor;
  const auto made = std::make_shared<Made>(executor);
  workers.post(
      {.share = std::move(share), .number = workers.new_client()},
      {.run =
           [made, make = std::move(make), executor, guard = asio::make_work_guard(executor)] {
             auto result = std::make_shared<Result<T>>(make());
             post(executor, [made, result] {
               made->result = std::move(*result);
               made->done.notify_all();
             });
           },
       .kind = std::move(kind),
       .is_long = is_long});
  while (!made->result) co_await made->done.wait();
  co_return *std::move(made->result);
}

}  // namespace multitetra

// Runs work on the worker threads and resumes the coroutine afterwards.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "common/base/result.hpp"
#include "common/net/async_event.hpp"
#include "common/net/coroutines.hpp"
#include "common/net/net.hpp"
#include "server/service/catch_as_error.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

// Calls start(done), then waits on the executor until done(result) is called.
template <typename T>
[[nodiscard]] asio::awaitable<Result<T>> result_of(
    std::function<void(std::function<void(Result<T>)> done)> start) {
  struct Waiting {
    explicit Waiting(asio::any_io_executor executor) : done(std::move(executor)) {}
    std::optional<Result<T>> result;
    AsyncEvent done;
  };
  const auto waiting = std::make_shared<Waiting>(co_await asio::this_coro::executor);
  start([waiting](Result<T> result) {
    waiting->result = std::move(result);
    waiting->done.notify_all();
  });
  while (!waiting->result) co_await waiting->done.wait();
  co_return *std::move(waiting->result);
}

// Runs `make` on a worker through the fair queue and returns its result, or an error if it throws.
// Keeps the executor running meanwhile.
template <typename T>
[[nodiscard]] asio::awaitable<Result<T>> run_on_workers(Workers& workers, std::string share,
                                                        std::string kind, bool is_long,
                                                        std::stop_token stop,
                                                        std::function<Result<T>()> make) {
  const asio::any_io_executor executor = co_await asio::this_coro::executor;
  std::function<void(std::function<void(Result<T>)>)> start =
      [&](std::function<void(Result<T>)> done) {
        auto run = [make = std::move(make), done = std::move(done), executor, kind, stop,
                    guard = asio::make_work_guard(executor)] {
          auto result = std::make_shared<Result<T>>(catch_as_error(kind, "", stop, make));
          post(executor, [done, result] { done(std::move(*result)); });
        };
        workers.post({.share = std::move(share), .number = workers.new_client()},
                     {.run = std::move(run), .kind = std::move(kind), .is_long = is_long});
      };
  co_return co_await result_of<T>(std::move(start));
}

}  // namespace multitetra

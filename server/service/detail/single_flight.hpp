// One computation for all concurrent callers with the same key.
//
// The first caller computes, on its own thread; the others wait for its result. A caller that is
// stopped leaves at once, and the computation itself is stopped when no caller is left. So a client
// that disconnects takes nothing from another with the same request.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "common/base/in_parallel.hpp"

namespace multitetra {

// Safe to use from several threads at once. Every caller gets a copy of the Value.
template <typename Key, typename Value>
class SingleFlight {
 public:
  // Returns compute(stop), or the result of a computation that runs already; an exception reaches
  // all callers. Throws Cancelled soon after `stop` is triggered. A Value may throw when it is
  // copied, then the caller of that copy gets the exception; not when it is moved.
  [[nodiscard]] Value get(const Key& key, const std::stop_token& stop,
                          const std::function<Value(std::stop_token)>& compute) {
    std::unique_lock lock(mutex_);
    const auto found = calls_.find(key);
    if (found != calls_.end() && found->second->interested > 0) {
      return wait_for(found->second, stop, lock);
    }
    // A computation without callers ends by itself.
    const auto call = std::make_shared<Call>();
    calls_[key] = call;
    lock.unlock();
    return compute_for_all(key, call, stop, compute);
  }

  // The number of callers for that key.
  [[nodiscard]] std::size_t interested(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = calls_.find(key);
    return found == calls_.end() ? 0 : found->second->interested;
  }

 private:
  struct Call {
    std::size_t interested = 1;
    std::stop_source stop;
    std::optional<Value> value;
    std::exception_ptr failure;
    std::condition_variable_any done;

    [[nodiscard]] bool is_done() const { return value || failure; }
    void abandon() {
      if (--interested == 0) stop.request_stop();
    }
  };

  Value wait_for(const std::shared_ptr<Call> call, const std::stop_token& stop,
                 std::unique_lock<std::mutex>& lock) {
    ++call->interested;
    if (!call->done.wait(lock, stop, [&] { return call->is_done(); })) {
      call->abandon();
      throw Cancelled{};
    }
    lock.unlock();  // A finished result does not change any more.
    if (call->failure) std::rethrow_exception(call->failure);
    return *call->value;
  }

  Value compute_for_all(const Key& key, const std::shared_ptr<Call>& call,
                        const std::stop_token& stop,
                        const std::function<Value(std::stop_token)>& compute) {
    std::optional<Value> value;
    std::exception_ptr failure;
    {
      const std::stop_callback leave(stop, [&] {
        const std::lock_guard lock(mutex_);
        call->abandon();
      });
      try {
        value = compute(call->stop.get_token());
      } catch (...) {
        failure = std::current_exception();
      }
    }
    {
      // Nothing here may throw: a flight that is never done would be waited for until the end.
      const std::lock_guard lock(mutex_);
      call->value = std::move(value);
      call->failure = failure;
      if (const auto mine = calls_.find(key); mine != calls_.end() && mine->second == call) {
        calls_.erase(mine);
      }
      call->done.notify_all();
    }
    if (failure) std::rethrow_exception(failure);
    return *call->value;  // Which does not change any more.
  }

  mutable std::mutex mutex_;  // Guards the flights and what they hold.
  std::map<Key, std::shared_ptr<Call>> calls_;
};

}  // namespace multitetra

// Shares one computation among all concurrent callers with the same key.
//
// The first caller computes on its own thread; the others wait for its result. A stopped caller
// returns at once; the computation is stopped when it has no callers left. So a client that
// disconnects does not affect another with the same request.
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
#include "common/base/yielding.hpp"

namespace multitetra {

// Thread-safe. Every caller gets a copy of the Value.
template <typename Key, typename Value>
class SingleFlight {
 public:
  // Returns compute(stop), or the result of a running computation; an exception reaches all
  // callers. Throws Cancelled soon after `stop` is triggered. Moving a Value must not throw.
  // Copying may: the exception then reaches only the caller of that copy.
  [[nodiscard]] Value get(const Key& key, const std::stop_token& stop,
                          const std::function<Value(std::stop_token)>& compute) {
    std::unique_lock lock(mutex_);
    const auto found = calls_.find(key);
    if (found != calls_.end() && found->second->callers > 0) {
      return wait_for(found->second, stop, lock);
    }
    // Any computation found above has no callers and is stopping: starts another.
    const auto call = std::make_shared<Call>();
    calls_[key] = call;
    lock.unlock();
    return compute_for_all(key, call, stop, compute);
  }

  // Returns the number of callers for that key.
  [[nodiscard]] std::size_t callers(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = calls_.find(key);
    return found == calls_.end() ? 0 : found->second->callers;
  }

 private:
  struct Call {
    std::size_t callers = 1;
    std::stop_source stop;
    std::optional<Value> value;
    std::exception_ptr failure;
    std::condition_variable_any done;

    [[nodiscard]] bool is_done() const { return value || failure; }
    void abandon() {
      if (--callers == 0) stop.request_stop();
    }
  };

  Value wait_for(const std::shared_ptr<Call> call, const std::stop_token& stop,
                 std::unique_lock<std::mutex>& lock) {
    ++call->callers;
    const BlockedScope blocked;
    if (!call->done.wait(lock, stop, [&] { return call->is_done(); })) {
      call->abandon();
      throw Cancelled{};
    }
    lock.unlock();  // A finished result is immutable.
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
      // Nothing here may throw: waiters of a flight that is never done would hang.
      const std::lock_guard lock(mutex_);
      call->value = std::move(value);
      call->failure = failure;
      if (const auto mine = calls_.find(key); mine != calls_.end() && mine->second == call) {
        calls_.erase(mine);
      }
      call->done.notify_all();
    }
    if (failure) std::rethrow_exception(failure);
    return *call->value;
  }

  mutable std::mutex mutex_;  // Guards calls_ and the flights' contents.
  std::map<Key, std::shared_ptr<Call>> calls_;
};

}  // namespace multitetra

// One computation for all who ask for the same thing at the same time.
//
// The first to ask computes, on its own thread; the others wait for its result. Whoever is stopped
// leaves at once, and the computation itself is stopped when nobody is left who wants it. So a
// client that goes away takes nothing from another that asked for the same.
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

// Safe to use from several threads at once. Value is copied to everybody.
template <typename Key, typename Value>
class SingleFlight {
 public:
  // compute(stop) where nobody computes it yet, otherwise the result of who does; an exception is
  // everybody's. Throws Cancelled soon after `stop` is triggered. A Value may throw when it is
  // copied, then whoever wanted that copy gets the exception; not when it is moved.
  [[nodiscard]] Value get(const Key& key, const std::stop_token& stop,
                          const std::function<Value(std::stop_token)>& compute) {
    std::unique_lock lock(mutex_);
    const auto found = flights_.find(key);
    if (found != flights_.end() && found->second->interested > 0) {
      return wait_for(found->second, stop, lock);
    }
    // One that nobody wants any more is left to end by itself.
    const auto flight = std::make_shared<Flight>();
    flights_[key] = flight;
    lock.unlock();
    return compute_for_all(key, flight, stop, compute);
  }

  // How many want what is computed for that key now.
  [[nodiscard]] std::size_t interested(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = flights_.find(key);
    return found == flights_.end() ? 0 : found->second->interested;
  }

 private:
  struct Flight {
    std::size_t interested = 1;
    std::stop_source stop;
    std::optional<Value> value;
    std::exception_ptr trouble;
    std::condition_variable_any done;

    [[nodiscard]] bool is_done() const { return value || trouble; }
    void lose_interest() {
      if (--interested == 0) stop.request_stop();
    }
  };

  Value wait_for(const std::shared_ptr<Flight> flight, const std::stop_token& stop,
                 std::unique_lock<std::mutex>& lock) {
    ++flight->interested;
    if (!flight->done.wait(lock, stop, [&] { return flight->is_done(); })) {
      flight->lose_interest();
      throw Cancelled{};
    }
    lock.unlock();  // What is done does not change any more.
    if (flight->trouble) std::rethrow_exception(flight->trouble);
    return *flight->value;
  }

  Value compute_for_all(const Key& key, const std::shared_ptr<Flight>& flight,
                        const std::stop_token& stop,
                        const std::function<Value(std::stop_token)>& compute) {
    std::optional<Value> value;
    std::exception_ptr trouble;
    {
      const std::stop_callback leave(stop, [&] {
        const std::lock_guard lock(mutex_);
        flight->lose_interest();
      });
      try {
        value = compute(flight->stop.get_token());
      } catch (...) {
        trouble = std::current_exception();
      }
    }
    {
      // Nothing here may throw: a flight that is never done would be waited for until the end.
      const std::lock_guard lock(mutex_);
      flight->value = std::move(value);
      flight->trouble = trouble;
      if (const auto mine = flights_.find(key); mine != flights_.end() && mine->second == flight) {
        flights_.erase(mine);
      }
      flight->done.notify_all();
    }
    if (trouble) std::rethrow_exception(trouble);
    return *flight->value;  // Which does not change any more.
  }

  mutable std::mutex mutex_;  // Guards the flights and what they hold.
  std::map<Key, std::shared_ptr<Flight>> flights_;
};

}  // namespace multitetra

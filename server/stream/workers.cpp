#include "server/stream/workers.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

namespace multitetra {

Workers::Workers(std::size_t threads) : queue_(threads > 1 ? threads - 1 : 1) {
  for (std::size_t i = 0; i < std::max<std::size_t>(threads, 1); ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

Workers::~Workers() { join(); }

FairQueue::Client Workers::new_client() {
  const std::lock_guard lock(mutex_);
  return next_client_++;
}

void Workers::post(FairQueue::Client client, FairQueue::Job job) {
  {
    const std::lock_guard lock(mutex_);
    queue_.add(client, std::move(job));
  }
  something_to_do_.notify_one();
}

void Workers::join() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  something_to_do_.notify_all();
  threads_.clear();
}

std::size_t Workers::waiting() const {
  const std::lock_guard lock(mutex_);
  return queue_.waiting();
}

void Workers::work() {
  using Clock = std::chrono::steady_clock;
  std::unique_lock lock(mutex_);
  for (;;) {
    std::optional<FairQueue::Taken> taken;
    something_to_do_.wait(lock, [&] {
      taken = queue_.take();
      return taken || (is_closed_ && queue_.waiting() == 0);
    });
    if (!taken) return;
    lock.unlock();
    const Clock::time_point start = Clock::now();
    taken->job.run();
    taken->job.run = nullptr;  // What it holds is let go before anybody waits for it.
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    lock.lock();
    queue_.done(taken->client, taken->job.is_long, seconds);
    // A long job that had to wait for this one may run now, on any thread.
    something_to_do_.notify_all();
  }
}

}  // namespace multitetra

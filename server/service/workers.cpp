#include "server/service/workers.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

namespace multitetra {

namespace {

// The default for unknown times, and the limit above which a job counts as long.
constexpr double kShortSeconds = 0.1;
constexpr double kLongSeconds = 0.5;

}  // namespace

Workers::Workers(std::size_t threads) : queue_(threads > 1 ? threads - 1 : 1) {
  for (std::size_t i = 0; i < std::max<std::size_t>(threads, 1); ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

Workers::~Workers() { join(); }

std::uint64_t Workers::new_client() {
  const std::lock_guard lock(mutex_);
  return next_client_++;
}

void Workers::post(const FairQueue::Client& client, Work work) {
  {
    const std::lock_guard lock(mutex_);
    const double expected = costs_.expected(work.kind, work.is_long ? kLongSeconds : kShortSeconds);
    queue_.add(client, {.run = std::move(work.run),
                        .is_long = work.is_long || expected > kLongSeconds,
                        .is_background = work.is_background,
                        .kind = std::move(work.kind),
                        .expected_seconds = expected});
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

Backlog Workers::backlog(const std::string& share) const {
  const std::lock_guard lock(mutex_);
  const double seconds = queue_.expected_seconds(share);
  const auto shares = static_cast<double>(std::max<std::size_t>(queue_.busy_shares(), 1));
  return {.seconds = seconds, .seconds_until_done = seconds * shares};
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
    taken->job.run = nullptr;  // Destroys what it holds before other jobs wait for it.
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    lock.lock();
    queue_.done(*taken, seconds);
    costs_.note(taken->job.kind, seconds);
    // A long job that had to wait for this one may run now, on any thread.
    something_to_do_.notify_all();
  }
}

}  // namespace multitetra

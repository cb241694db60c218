#include "server/service/workers.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "server/operations/deadline.hpp"

namespace multitetra {

namespace {

// A job counts as long above the first if its time is a forecast, above the second if jobs of its
// kind took that long. They are also the times assumed for unknown kinds.
constexpr double kShortSeconds = 0.1;
constexpr double kLongSeconds = 0.5;
constexpr double kForecastSeconds = 0.005;

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
  if (!work.forecast) {
    const std::lock_guard lock(mutex_);
    add(client, std::move(work), std::nullopt);
    return;
  }
  const bool is_background = work.is_background;
  const std::lock_guard lock(mutex_);
  const double following = costs_.expected(work.kind, work.is_long ? kLongSeconds : kShortSeconds);
  auto first = [this, client, work = std::move(work)]() mutable {
    const std::optional<double> seconds = work.forecast();
    work.forecast = nullptr;
    const std::lock_guard of_queue(mutex_);
    add(client, std::move(work), seconds);
  };
  queue_.add(client, {.run = std::move(first),
                      .is_background = is_background,
                      .kind = "forecast",
                      .expected_seconds = costs_.expected("forecast", kForecastSeconds),
                      .following_seconds = following});
  work_available_.notify_one();
}

void Workers::add(const FairQueue::Client& client, Work work, std::optional<double> seconds) {
  const double learned = costs_.expected(work.kind, work.is_long ? kLongSeconds : kShortSeconds);
  const double expected = seconds.value_or(learned);
  // Forecasts may be several times too small.
  const bool is_long = seconds ? expected > kShortSeconds : work.is_long || learned > kLongSeconds;
  queue_.add(client, {.run = std::move(work.run),
                      .is_long = is_long,
                      .is_background = work.is_background,
                      .kind = std::move(work.kind),
                      .expected_seconds = expected});
  work_available_.notify_one();
}

void Workers::join() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  work_available_.notify_all();
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
  std::unique_lock lock(mutex_);
  for (;;) {
    std::optional<FairQueue::DequeuedJob> taken;
    work_available_.wait(lock, [&] {
      taken = queue_.take();
      return taken || (is_closed_ && queue_.waiting() == 0);
    });
    if (!taken) return;
    lock.unlock();
    const Clock::time_point start = Clock::now();
    taken->job.run();
    taken->job.run = nullptr;  // Releases its captures before others wait for them.
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    lock.lock();
    queue_.done(*taken, seconds);
    costs_.record(taken->job.kind, seconds);
    // A long job that was held back may now run on any thread.
    work_available_.notify_all();
  }
}

}  // namespace multitetra

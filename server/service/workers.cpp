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
constexpr double kLongSeconds = FairQueue::kLongSeconds;
constexpr double kForecastSeconds = 0.005;
// A job is overdue if it takes this long, and twice as long as expected.
constexpr double kOverdueSeconds = 0.25;
constexpr auto kOverdueCheck = std::chrono::milliseconds(50);

// The kind under which the ratio of actual to forecast times is recorded.
std::string ratio_of(const std::string& kind) { return kind + " per forecast"; }

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

// As many threads again stand by for jobs that turn out to be long.
Workers::Workers(std::size_t threads)
    : queue_(threads > 1 ? threads - 1 : 1), max_running_(std::max<std::size_t>(threads, 1)) {
  for (std::size_t i = 0; i < 2 * max_running_; ++i) {
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
  const double expected = seconds ? *seconds * costs_.expected(ratio_of(work.kind), 1) : learned;
  // Forecasts may be several times too small.
  const bool is_long = seconds ? expected > kShortSeconds : work.is_long || learned > kLongSeconds;
  queue_.add(client, {.run = std::move(work.run),
                      .is_long = is_long,
                      .is_background = work.is_background,
                      .kind = std::move(work.kind),
                      .expected_seconds = expected,
                      .forecast_seconds = seconds.value_or(0)});
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

std::optional<FairQueue::DequeuedJob> Workers::take() {
  const std::size_t allowed = max_running_ + std::min(queue_.excess_long(), max_running_);
  return running_.size() < allowed ? queue_.take() : std::nullopt;
}

void Workers::note_overdue() {
  for (Running& one : running_) {
    const double seconds = seconds_since(one.start);
    const double expected = one.taken.job.expected_seconds;
    if (one.taken.job.is_long || seconds < std::max(kOverdueSeconds, 2 * expected)) continue;
    queue_.overdue(one.taken, seconds);
    record(one, seconds);
  }
}

void Workers::record(const Running& one, double seconds) {
  const std::string& kind = one.taken.job.kind;
  costs_.record(kind, seconds);
  const double forecast = one.taken.job.forecast_seconds;
  if (forecast > 0) costs_.record(ratio_of(kind), seconds / forecast);
}

void Workers::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    std::optional<FairQueue::DequeuedJob> taken;
    const auto has_work = [&] {
      note_overdue();
      taken = take();
      return taken || (is_closed_ && queue_.waiting() == 0);
    };
    while (!has_work()) {
      if (running_.empty()) {
        work_available_.wait(lock);
      } else {
        work_available_.wait_for(lock, kOverdueCheck);
      }
    }
    if (!taken) return;
    const auto one = running_.insert(running_.end(), {*std::move(taken), Clock::now()});
    lock.unlock();
    one->taken.job.run();
    one->taken.job.run = nullptr;  // Releases its captures before others wait for them.
    const double seconds = seconds_since(one->start);
    lock.lock();
    queue_.done(one->taken, seconds);
    record(*one, seconds);
    running_.erase(one);
    // A long job that was held back may now run on any thread.
    work_available_.notify_all();
  }
}

}  // namespace multitetra

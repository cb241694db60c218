#include "server/service/workers.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/yielding.hpp"

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
// A job runs at least this long, and as long as it has paused, before it pauses. As it may hold
// what the others need, such as the surface that they request too, its pauses end.
constexpr auto kShortestRun = std::chrono::milliseconds(250);
constexpr auto kLongestPause = std::chrono::seconds(2);

// The kind under which the ratio of actual to forecast times is recorded.
std::string ratio_of(const std::string& kind) { return kind + " per forecast"; }

}  // namespace

class Workers::Pauses : public Yields {
 public:
  Pauses(Workers& workers, Running& one) : workers_(workers), one_(one) {}
  [[nodiscard]] bool is_due() const override {
    return one_.should_pause.load(std::memory_order_relaxed);
  }
  void wait() override { workers_.pause(one_); }
  void block() override { is_blocked_ = workers_.begin_pause(one_); }
  void unblock() override {
    if (std::exchange(is_blocked_, false)) workers_.end_pause(one_);
  }

 private:
  Workers& workers_;
  Running& one_;
  bool is_blocked_ = false;
};

// As many threads again stand by for jobs that turn out to be long, and for those that pause.
Workers::Workers(std::size_t threads)
    : queue_(threads > 1 ? threads - 1 : 1), max_running_(std::max<std::size_t>(threads, 1)) {
  for (std::size_t i = 0; i < 3 * max_running_; ++i) {
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
                      .forecast_seconds = seconds.value_or(0),
                      .time = std::move(work.time)});
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
  return running_.size() - paused_ < allowed ? queue_.take() : std::nullopt;
}

void Workers::look_at_running() {
  const Clock::time_point now = Clock::now();
  for (Running& one : running_) {
    const double seconds = one.taken.job.time->seconds(now);
    const double expected = one.taken.job.expected_seconds;
    if (!one.taken.job.is_long && seconds >= std::max(kOverdueSeconds, 2 * expected)) {
      queue_.overdue(one.taken, seconds);
      record(one, seconds);
    }
    if (now >= one.no_pause_before && paused_ < max_running_ && queue_.should_pause(one.taken)) {
      one.should_pause = true;
    }
  }
}

void Workers::pause(Running& one) {
  std::unique_lock lock(mutex_);
  one.should_pause = false;
  if (paused_ >= max_running_ || !queue_.should_pause(one.taken)) return;
  const Clock::time_point start = Clock::now();
  one.taken.job.time->end();
  queue_.paused(one.taken);
  ++paused_;
  work_available_.notify_one();
  may_resume_.notify_all();
  may_resume_.wait_until(lock, start + kLongestPause,
                         [&] { return queue_.should_resume(one.taken); });
  --paused_;
  queue_.resumed(one.taken);
  one.should_pause = false;  // Noted again during the pause.
  one.taken.job.time->begin();
  const Clock::time_point end = Clock::now();
  one.no_pause_before = end + std::max<Clock::duration>(kShortestRun, end - start);
}

bool Workers::begin_pause(Running& one) {
  const std::lock_guard lock(mutex_);
  if (!one.taken.job.is_long || paused_ >= max_running_) return false;
  queue_.paused(one.taken);
  ++paused_;
  work_available_.notify_one();
  may_resume_.notify_all();
  return true;
}

void Workers::end_pause(Running& one) {
  const std::lock_guard lock(mutex_);
  --paused_;
  queue_.resumed(one.taken);
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
      look_at_running();
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
    running_.emplace_back(*std::move(taken), Clock::now());
    const auto one = std::prev(running_.end());
    std::shared_ptr<WorkTime>& time = one->taken.job.time;
    if (!time) time = std::make_shared<WorkTime>();
    time->begin();
    lock.unlock();
    {
      Pauses pauses(*this, *one);
      const YieldScope scope(&pauses);
      one->taken.job.run();
    }
    one->taken.job.run = nullptr;  // Releases its captures before others wait for them.
    lock.lock();
    time->end();
    const double seconds = time->seconds();
    queue_.done(one->taken, seconds);
    record(*one, seconds);
    running_.erase(one);
    // A long job that was held back may now run on any thread.
    work_available_.notify_all();
    may_resume_.notify_all();
  }
}

}  // namespace multitetra

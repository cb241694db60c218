// The worker threads, shared fairly among clients (see fair_queue.hpp).
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/service/fair_queue.hpp"
#include "server/service/work_costs.hpp"
#include "server/service/work_time.hpp"

namespace multitetra {

// Predicts the seconds that work will take, in a small fraction of that time; nullopt if unknown.
// Must not throw.
using Forecast = std::function<std::optional<double>()>;

struct Work {
  std::function<void()> run = {};  // Must not throw.
  // Jobs of one kind, that is a dataset and an operation, are expected to take similar times.
  // Empty: unknown.
  std::string kind = {};
  bool is_long = false;  // Jobs whose kind proved long count as long too.
  // Runs only when no other job can.
  bool is_background = false;
  // If set, measures the time of `run`, also while it runs.
  std::shared_ptr<WorkTime> time = {};
  // If set, runs first, in a job of its own. Its result, if known, overrides `is_long`.
  Forecast forecast = {};
};

// The pending work of a share.
struct Backlog {
  // The expected time of its waiting and running jobs.
  double seconds = 0;
  // The expected time including the other shares' jobs that run meanwhile.
  double seconds_until_done = 0;
};

// Thread-safe.
class Workers {
 public:
  // Runs `threads` jobs at the same time, at least 1; all but one of them may be long. Jobs that
  // turn out to be long do not keep others from their places, and between their pieces
  // (yielding.hpp) long jobs pause for others that are due before them: at most `threads` of them,
  // which keep their memory meanwhile.
  explicit Workers(std::size_t threads);
  // Runs all waiting jobs before it returns.
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  // Returns a unique number for a client.
  [[nodiscard]] std::uint64_t new_client();
  void post(const FairQueue::Client& client, Work work);
  // Runs all jobs and ends the threads. Nothing may be posted afterwards.
  void join();
  [[nodiscard]] std::size_t waiting() const;
  [[nodiscard]] Backlog backlog(const std::string& share) const;

 private:
  class Pauses;
  struct Running {
    FairQueue::DequeuedJob taken;
    Clock::time_point no_pause_before;
    std::atomic<bool> should_pause = false;
  };
  // Returns the next job, if one more may run.
  [[nodiscard]] std::optional<FairQueue::DequeuedJob> take();
  // Reports jobs that run longer than expected to the queue, before they end, and notes which ones
  // should pause.
  void look_at_running();
  // Returns when the job should continue, or after kLongestPause.
  void pause(Running& one);
  // A long job gives its place to others while it waits for one of them. Returns whether it does.
  [[nodiscard]] bool begin_pause(Running& one);
  void end_pause(Running& one);
  void record(const Running& one, double seconds);
  // `seconds` is the forecast, if any.
  void add(const FairQueue::Client& client, Work work, std::optional<double> seconds);
  void work();

  mutable std::mutex mutex_;  // Guards all but max_running_ and threads_.
  std::condition_variable work_available_;
  std::condition_variable may_resume_;  // A job has ended or paused.
  FairQueue queue_;
  WorkCosts costs_;
  const std::size_t max_running_;  // Beside those for which overdue jobs make room.
  std::list<Running> running_;     // Includes paused ones.
  std::size_t paused_ = 0;
  std::uint64_t next_client_ = 0;
  bool is_closed_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace multitetra

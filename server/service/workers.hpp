// The threads that make steps, shared fairly among clients (see fair_queue.hpp).
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/service/fair_queue.hpp"
#include "server/service/work_costs.hpp"

namespace multitetra {

// Seconds that work will take, found out in a small part of them; nullopt where that is not known.
// Must not throw.
using Forecast = std::function<std::optional<double>()>;

// A job of a worker.
struct Work {
  std::function<void()> run;  // Must not throw.
  // Work of one kind takes about as long each time, as far as is known: a dataset and what is made
  // of it. Empty: nothing is known of it.
  std::string kind = {};
  bool is_long = false;        // Also what turns out to be, of its kind, is long.
  bool is_background = false;  // Comes after all that is not.
  // If there is one, a worker calls it first, in a job of its own; where it knows, `is_long` does
  // not count.
  Forecast forecast = {};
};

// The waiting work of a share, and when it will be done.
struct Backlog {
  double seconds = 0;  // Expected of what waits and runs,
  // With the other jobs that run meanwhile.
  double seconds_until_done = 0;
};

// Safe to use from several threads at once.
class Workers {
 public:
  // `threads` jobs run at the same time, at least 1; all but one of them may be long.
  explicit Workers(std::size_t threads);
  // Runs what is waiting, then ends.
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  // A unique number for a client.
  [[nodiscard]] std::uint64_t new_client();
  void post(const FairQueue::Client& client, Work work);
  // Returns when all jobs have run and the threads have ended. Nothing may be posted afterwards.
  void join();
  [[nodiscard]] std::size_t waiting() const;
  [[nodiscard]] Backlog backlog(const std::string& share) const;

 private:
  // `seconds` is the forecast, if there is one.
  void add(const FairQueue::Client& client, Work work, std::optional<double> seconds);
  void work();

  mutable std::mutex mutex_;  // Guards queue_, costs_, next_client_ and is_closed_.
  std::condition_variable something_to_do_;
  FairQueue queue_;
  WorkCosts costs_;
  std::uint64_t next_client_ = 0;
  bool is_closed_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace multitetra

// The threads that make steps, shared fairly among clients (see fair_queue.hpp).
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "server/stream/fair_queue.hpp"

namespace multitetra {

// Safe to use from several threads at once.
class Workers {
 public:
  // `threads` jobs run at the same time, at least 1; all but one of them may be long.
  explicit Workers(std::size_t threads);
  // Runs what is waiting, then ends.
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  // A number for a client that nobody else has.
  [[nodiscard]] FairQueue::Client new_client();
  // The job must not throw.
  void post(FairQueue::Client client, FairQueue::Job job);
  // Returns when all jobs have run and the threads have ended. Nothing may be posted afterwards.
  void join();
  [[nodiscard]] std::size_t waiting() const;

 private:
  void work();

  mutable std::mutex mutex_;  // Guards queue_, next_client_ and is_closed_.
  std::condition_variable something_to_do_;
  FairQueue queue_;
  FairQueue::Client next_client_ = 0;
  bool is_closed_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace multitetra

// Whose work comes next: that of the share which was served for the shortest time, and in it of the
// client who was.
//
// A share is what somebody can have who comes by many connections: an address, or a token. So a
// hundred connections from one address get no more than a single one from another, and share that
// among themselves. Times count from when a share or a client has something to do again, so that
// whoever was idle saves up no claim. What a job is expected to take counts from its beginning,
// what it has taken at its end.
//
// Long jobs never take all workers, a share has one of them at a time and one job beside it: so
// what is short finds a worker, and who comes new does not wait for all that runs. Nobody waits for
// what runs in the background: it comes when nothing else could run.
//
// Pure: no thread, no clock.
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace multitetra {

class FairQueue {
 public:
  struct Client {
    std::string share = {};
    std::uint64_t number = 0;  // Among all clients.

    friend auto operator<=>(const Client&, const Client&) = default;
  };
  struct Job {
    std::function<void()> run;
    bool is_long = false;
    bool is_background = false;  // Comes after all that is not.
    std::string kind = {};       // For whoever learns from what it takes.
    double expected_seconds = 0;
  };
  struct Taken {
    Client client = {};
    Job job;
  };

  // At most `max_long` long jobs run at the same time; at least 1.
  explicit FairQueue(std::size_t max_long) : max_long_(std::max<std::size_t>(max_long, 1)) {}

  void add(const Client& client, Job job) {
    Share& share = shares_[client.share];
    if (share.is_idle()) share.seconds = std::max(share.seconds, now_);
    Queue& queue = share.clients[client.number];
    if (queue.is_idle()) queue.seconds = std::max(queue.seconds, share.now);
    share.expected_seconds += job.expected_seconds;
    queue.jobs.push_back(std::move(job));
    ++queue.waiting;
    ++share.waiting;
    ++waiting_;
  }

  // The next job to run; nullopt when none may run now. done() must follow.
  [[nodiscard]] std::optional<Taken> take() {
    auto next = shares_.end();
    std::optional<Turn> best;
    std::uint64_t number = 0;
    for (auto at = shares_.begin(); at != shares_.end(); ++at) {
      const auto in_share = next_of(at->second);
      if (!in_share) continue;
      const Turn turn = {in_share->second.is_background, at->second.seconds};
      if (best && *best <= turn) continue;
      best = turn;
      next = at;
      number = in_share->first;
    }
    if (!best) return std::nullopt;
    Share& share = next->second;
    Queue& queue = share.clients.at(number);
    Taken taken{{next->first, number}, std::move(queue.jobs.front())};
    queue.jobs.pop_front();
    now_ = std::max(now_, share.seconds);
    share.now = std::max(share.now, queue.seconds);
    begin(share, taken.job);
    begin(queue, taken.job);
    --waiting_;
    if (taken.job.is_long) {
      ++running_long_;
      ++share.running_long;
    }
    return taken;
  }

  // The job that was taken has run for `seconds`.
  void done(const Taken& taken, double seconds) {
    const auto at = shares_.find(taken.client.share);
    Share& share = at->second;
    if (taken.job.is_long) {
      --running_long_;
      --share.running_long;
    }
    share.expected_seconds -= taken.job.expected_seconds;
    end(share, taken.job, seconds);
    end(share.clients.at(taken.client.number), taken.job, seconds);
    // Who is idle is remembered as long as he is ahead of the others.
    std::erase_if(share.clients, [&share](const auto& entry) {
      return entry.second.is_idle() && entry.second.seconds <= share.now;
    });
    std::erase_if(shares_, [this](const auto& entry) {
      return entry.second.is_idle() && entry.second.seconds <= now_;
    });
  }

  [[nodiscard]] std::size_t waiting() const { return waiting_; }
  // What is expected of the jobs of a share that wait or run.
  [[nodiscard]] double expected_seconds(const std::string& share) const {
    const auto found = shares_.find(share);
    return found == shares_.end() ? 0 : std::max(found->second.expected_seconds, 0.0);
  }
  // How many shares have something to do.
  [[nodiscard]] std::size_t busy_shares() const {
    return static_cast<std::size_t>(std::count_if(
        shares_.begin(), shares_.end(), [](const auto& entry) { return !entry.second.is_idle(); }));
  }

 private:
  static constexpr std::size_t kMostOfAShare = 2;  // Jobs that run at the same time,
  static constexpr std::size_t kMostLongOfAShare = 1;

  struct Served {
    double seconds = 0;
    std::size_t running = 0;
    std::size_t waiting = 0;

    [[nodiscard]] bool is_idle() const { return running == 0 && waiting == 0; }
  };
  struct Queue : Served {
    std::deque<Job> jobs;
  };
  struct Share : Served {
    double expected_seconds = 0;  // Of all that waits or runs.
    std::size_t running_long = 0;
    double now = 0;  // The largest time served of a client at which a job of it was taken.
    std::map<std::uint64_t, Queue> clients;
  };
  struct Turn {
    bool is_background = false;
    double seconds = 0;

    friend auto operator<=>(const Turn&, const Turn&) = default;
  };

  // The client of a share whose first job comes next, if one may run.
  [[nodiscard]] std::optional<std::pair<std::uint64_t, Turn>> next_of(const Share& share) const {
    if (share.waiting == 0 || share.running >= kMostOfAShare) return std::nullopt;
    const bool may_be_long = running_long_ < max_long_ && share.running_long < kMostLongOfAShare;
    std::optional<std::pair<std::uint64_t, Turn>> next;
    for (const auto& [number, queue] : share.clients) {
      if (queue.jobs.empty() || (queue.jobs.front().is_long && !may_be_long)) continue;
      const Turn turn = {queue.jobs.front().is_background, queue.seconds};
      if (!next || turn < next->second) next = {number, turn};
    }
    return next;
  }
  static void begin(Served& served, const Job& job) {
    --served.waiting;
    ++served.running;
    served.seconds += job.expected_seconds;
  }
  static void end(Served& served, const Job& job, double seconds) {
    --served.running;
    served.seconds += seconds - job.expected_seconds;
  }

  std::size_t max_long_;
  std::size_t running_long_ = 0;
  std::size_t waiting_ = 0;
  double now_ = 0;  // The largest time served of a share at which a job of it was taken.
  std::map<std::string, Share> shares_;
};

}  // namespace multitetra

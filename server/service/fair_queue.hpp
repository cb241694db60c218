// Weighted fair queueing of jobs by their duration.
//
// A *share* is what one client gets, however many connections it opens: an address, or a token. A
// job's virtual finish time is when it would be done if all busy shares were served at once, each
// with an equal part of the workers. Jobs are taken in the order of these times. So a small job
// passes long ones of any client; a hundred connections from one address get no more than a single
// one from another; and a long job is done about as soon as with simultaneous service, however many
// small ones arrive. The same rule orders the clients within a share. A job is charged its expected
// time when it begins; the charge is corrected to its actual time when it ends.
//
// Virtual time advances with the work done, divided by the weight of the busy shares. An idle share
// resumes at the current virtual time, so idling earns no credit. Related networks (see
// share_levels()) have the joint weight of a few shares.
//
// Long jobs never take all workers, and a share runs at most one long job and one other, so a short
// job finds a worker. A job that was expected to be short and is not counts as long from the time
// when that is noticed; waiting jobs of its kind are corrected in proportion. A long job pauses
// between its pieces while another one that is due before it has its place. Background jobs run
// when no other job can.
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
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/operations/client_address.hpp"
#include "server/service/work_time.hpp"

namespace multitetra {

class FairQueue {
 public:
  struct Client {
    std::string share = {};
    std::uint64_t number = 0;  // Unique among all clients.

    friend auto operator<=>(const Client&, const Client&) = default;
  };
  struct Job {
    std::function<void()> run;
    bool is_long = false;
    // Runs only when no other job can.
    bool is_background = false;
    std::string kind = {};  // For duration statistics.
    double expected_seconds = 0;
    double following_seconds = 0;  // Expected time of the job that this one will add.
    double forecast_seconds = 0;   // What a forecast said; 0: there was none.
    std::shared_ptr<WorkTime> time = {};
  };
  struct DequeuedJob {
    Client client = {};
    Job job;
    // The weight of the share when the job was taken.
    double weight = 1;
    double finish = 0;  // In virtual time.
  };

  // Runs at most `max_long` long jobs (at least 1) at the same time.
  explicit FairQueue(std::size_t max_long) : max_long_(std::max<std::size_t>(max_long, 1)) {}

  void add(const Client& client, Job job) {
    const auto [at, is_new] = shares_.try_emplace(client.share);
    Share& share = at->second;
    if (is_new) note_networks(share, client.share);
    if (share.is_idle()) {
      share.served_until = std::max(share.served_until, virtual_now_);
      ++busy_shares_;
      for (const auto& network : share.networks) ++network->second.busy_count;
    }
    Queue& queue = share.clients[client.number];
    if (queue.is_idle()) queue.served_until = std::max(queue.served_until, share.virtual_now);
    share.expected_seconds += job.expected_seconds + job.following_seconds;
    queue.jobs.push_back(std::move(job));
    ++queue.waiting;
    ++share.waiting;
    ++waiting_;
  }

  // Returns the next job to run, or nullopt if none may run now. done() must follow.
  [[nodiscard]] std::optional<DequeuedJob> take() {
    auto next = shares_.end();
    std::optional<ClientTurn> best;
    std::uint64_t number = 0;
    for (auto at = shares_.begin(); at != shares_.end(); ++at) {
      const auto in_share = next_of(at->second, running_long_ < max_long_);
      if (!in_share) continue;
      const Job& job = in_share->second->jobs.front();
      const ClientTurn turn = turn_of(at->second, job, weight_of(at->second));
      if (best && *best <= turn) continue;
      best = turn;
      next = at;
      number = in_share->first;
    }
    if (!best) return std::nullopt;
    Share& share = next->second;
    Queue& queue = share.clients.at(number);
    DequeuedJob taken{{next->first, number}, std::move(queue.jobs.front()), weight_of(share)};
    queue.jobs.pop_front();
    ++turns_;
    begin(share, taken.job, taken.weight);
    begin(queue, taken.job, 1);
    taken.finish = share.served_until;
    --waiting_;
    if (taken.job.is_long) {
      ++running_long_;
      ++share.running_long;
    }
    return taken;
  }

  // Reports that a taken job has run for `seconds`.
  void done(const DequeuedJob& taken, double seconds) {
    const auto at = shares_.find(taken.client.share);
    Share& share = at->second;
    if (taken.job.is_long) {
      --running_long_;
      --share.running_long;
    }
    share.expected_seconds -= taken.job.expected_seconds + taken.job.following_seconds;
    virtual_now_ += seconds / busy_weight();
    share.virtual_now += seconds / static_cast<double>(share.busy_clients());
    end(share, taken.job, seconds, taken.weight);
    end(share.clients.at(taken.client.number), taken.job, seconds, 1);
    if (share.is_idle()) {
      --busy_shares_;
      for (const auto& network : share.networks) --network->second.busy_count;
    }
    drop_idle_clients(share);
  }

  // Reports that a taken job has run for `seconds`, more than expected, and has not ended.
  void overdue(DequeuedJob& taken, double seconds) {
    const double factor = seconds / std::max(taken.job.expected_seconds, 1e-3);
    if (factor <= 1) return;
    Share& share = shares_.find(taken.client.share)->second;
    if (!std::exchange(taken.job.is_long, true)) {
      ++running_long_;
      ++share.running_long;
    }
    const double more = seconds - std::exchange(taken.job.expected_seconds, seconds);
    share.expected_seconds += more;
    share.served_until += more / taken.weight;
    taken.finish += more / taken.weight;
    share.clients.at(taken.client.number).served_until += more;
    for (auto& [name, other] : shares_) {
      for (auto& [number, queue] : other.clients) {
        for (Job& job : queue.jobs) {
          if (job.kind != taken.job.kind) continue;
          other.expected_seconds += (factor - 1) * job.expected_seconds;
          job.expected_seconds *= factor;
          job.is_long = job.is_long || job.expected_seconds > kLongSeconds;
        }
      }
    }
  }
  // Returns whether a running long job should pause: another one that is due before it waits for
  // its place.
  [[nodiscard]] bool should_pause(const DequeuedJob& taken) const {
    // With more than allowed, its place would not become free.
    return taken.job.is_long && running_long_ == max_long_ && has_long_before(taken);
  }
  // Returns whether a paused job should continue.
  [[nodiscard]] bool should_resume(const DequeuedJob& taken) const {
    return running_long_ < max_long_ && !has_long_before(taken);
  }
  // Reports that a long job has paused, or continues.
  void paused(const DequeuedJob& taken) {
    if (taken.job.is_long) --running_long_;
  }
  void resumed(const DequeuedJob& taken) {
    if (taken.job.is_long) ++running_long_;
  }

  // Returns how many long jobs run above their limit, because they were expected to be short. As
  // many more workers keep short jobs from waiting for them.
  [[nodiscard]] std::size_t excess_long() const {
    return running_long_ > max_long_ ? running_long_ - max_long_ : 0;
  }

  [[nodiscard]] std::size_t waiting() const { return waiting_; }
  // Returns the expected time of a share's waiting and running jobs, in seconds.
  [[nodiscard]] double expected_seconds(const std::string& share) const {
    const auto found = shares_.find(share);
    return found == shares_.end() ? 0 : std::max(found->second.expected_seconds, 0.0);
  }
  // Returns the number of shares with waiting or running jobs.
  [[nodiscard]] std::size_t busy_shares() const { return busy_shares_; }

  // Jobs of unknown kinds that took or may take longer count as long.
  static constexpr double kLongSeconds = 0.5;

 private:
  static constexpr std::size_t kMaxJobsPerShare = 2;  // Concurrent jobs of one share.
  static constexpr std::size_t kMaxLongJobsPerShare = 1;

  struct Served {
    double served_until = 0;  // The virtual time up to which it has been served.
    std::uint64_t last_turn = 0;
    std::size_t running = 0;
    std::size_t waiting = 0;

    [[nodiscard]] bool is_idle() const { return running == 0 && waiting == 0; }
  };
  struct Queue : Served {
    std::deque<Job> jobs;
  };
  // The shares within one network.
  struct Network {
    // The weight of all of them is at most this.
    int shares = 1;
    std::size_t share_count = 0;
    std::size_t busy_count = 0;
  };
  using Networks = std::map<std::string, Network>;
  struct Share : Served {
    std::vector<Networks::iterator> networks;  // Empty for most shares.
    // Expected seconds of all waiting and running jobs.
    double expected_seconds = 0;
    std::size_t running_long = 0;
    double virtual_now = 0;  // The virtual time among the share's clients.
    std::map<std::uint64_t, Queue> clients;

    [[nodiscard]] std::size_t busy_clients() const {
      return static_cast<std::size_t>(
          std::count_if(clients.begin(), clients.end(),
                        [](const auto& entry) { return !entry.second.is_idle(); }));
    }
  };
  // The least turn is next: among equal finish times, the least recently served.
  struct ClientTurn {
    bool is_background = false;
    double finish = 0;
    std::uint64_t last_turn = 0;

    friend auto operator<=>(const ClientTurn&, const ClientTurn&) = default;
  };

  static ClientTurn turn_of(const Served& served, const Job& job, double weight) {
    return {job.is_background, served.served_until + job.expected_seconds / weight,
            served.last_turn};
  }
  // Returns a weight of at most 1. The busy shares of a network jointly have at most its weight.
  [[nodiscard]] double weight_of(const Share& share) const {
    double weight = 1;
    for (const auto& network : share.networks) {
      const Network& all = network->second;
      weight = std::min(weight, all.shares / static_cast<double>(all.busy_count));
    }
    return weight;
  }
  void note_networks(Share& share, const std::string& name) {
    const std::vector<ShareLevel> levels = share_levels(name);
    for (std::size_t i = 1; i < levels.size(); ++i) {  // The first level is the share itself.
      const auto at = networks_.try_emplace(levels[i].name, Network{levels[i].shares}).first;
      ++at->second.share_count;
      share.networks.push_back(at);
    }
  }
  [[nodiscard]] double busy_weight() const {
    double weight = 0;
    for (const auto& [name, share] : shares_) {
      if (!share.is_idle()) weight += weight_of(share);
    }
    return weight;
  }

  // Returns whether a long job of another share waits that is due before this one.
  [[nodiscard]] bool has_long_before(const DequeuedJob& taken) const {
    return std::any_of(shares_.begin(), shares_.end(), [&](const auto& entry) {
      const auto& [name, share] = entry;
      if (name == taken.client.share) return false;
      const auto next = next_of(share, /*has_place=*/true);
      if (!next || !next->second->jobs.front().is_long) return false;
      const ClientTurn turn = turn_of(share, next->second->jobs.front(), weight_of(share));
      return std::pair(turn.is_background, turn.finish) <
             std::pair(taken.job.is_background, taken.finish);
    });
  }
  // Returns the client whose first job is next in a share, if one may run. `has_place`: for a long
  // one, too.
  [[nodiscard]] static std::optional<std::pair<std::uint64_t, const Queue*>> next_of(
      const Share& share, bool has_place) {
    if (share.waiting == 0 || share.running >= kMaxJobsPerShare) return std::nullopt;
    const bool may_be_long = has_place && share.running_long < kMaxLongJobsPerShare;
    std::optional<std::pair<std::uint64_t, const Queue*>> next;
    std::optional<ClientTurn> best;
    for (const auto& [number, queue] : share.clients) {
      if (queue.jobs.empty() || (queue.jobs.front().is_long && !may_be_long)) continue;
      const ClientTurn turn = turn_of(queue, queue.jobs.front(), 1);
      if (best && *best <= turn) continue;
      best = turn;
      next = {number, &queue};
    }
    return next;
  }
  void begin(Served& served, const Job& job, double weight) const {
    --served.waiting;
    ++served.running;
    served.last_turn = turns_;
    served.served_until += job.expected_seconds / weight;
  }
  static void end(Served& served, const Job& job, double seconds, double weight) {
    --served.running;
    served.served_until += (seconds - job.expected_seconds) / weight;
  }

  // Removes idle shares and clients, except those that were served ahead of virtual time. Removes
  // all of them when no work is left.
  void drop_idle_clients(Share& share) {
    std::erase_if(share.clients, [&share](const auto& entry) {
      return entry.second.is_idle() && entry.second.served_until <= share.virtual_now;
    });
    std::erase_if(shares_, [this](const auto& entry) {
      const Share& one = entry.second;
      if (!one.is_idle() || (one.served_until > virtual_now_ && busy_shares_ > 0)) return false;
      for (const auto& network : one.networks) {
        if (--network->second.share_count == 0) networks_.erase(network);
      }
      return true;
    });
    if (shares_.empty()) virtual_now_ = 0;
  }

  std::size_t max_long_;
  std::size_t running_long_ = 0;
  std::size_t waiting_ = 0;
  std::uint64_t turns_ = 0;
  double virtual_now_ = 0;
  std::map<std::string, Share> shares_;
  Networks networks_;
  std::size_t busy_shares_ = 0;
};

}  // namespace multitetra

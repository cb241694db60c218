// Whose work comes next: that of the client who was served for the shortest time.
//
// Every client has a queue of its own. Times count from when a client has something to do again, so
// that an idle client saves up no claim, and a client with much to do cannot keep the others
// waiting longer than its running job. Long jobs never take all workers: what is short finds one.
// Nobody waits for what runs in the background: it comes when nothing else could run.
//
// Pure: no thread, no clock.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <utility>

namespace multitetra {

class FairQueue {
 public:
  using Client = std::uint64_t;
  struct Job {
    std::function<void()> run;
    bool is_long = false;
    bool is_background = false;  // Comes after all that is not.
  };
  struct Taken {
    Client client = 0;
    Job job;
  };

  // At most `max_long` long jobs run at the same time; at least 1.
  explicit FairQueue(std::size_t max_long) : max_long_(std::max<std::size_t>(max_long, 1)) {}

  void add(Client client, Job job) {
    const auto [at, is_new] = clients_.try_emplace(client);
    Served& served = at->second;
    if (is_new || (served.waiting.empty() && served.running == 0)) {
      served.seconds = std::max(served.seconds, now_);
    }
    served.waiting.push_back(std::move(job));
    ++waiting_;
  }

  // The next job to run; nullopt when none may run now. done() must follow.
  [[nodiscard]] std::optional<Taken> take() {
    auto next = clients_.end();
    for (auto at = clients_.begin(); at != clients_.end(); ++at) {
      if (at->second.waiting.empty()) continue;
      if (at->second.waiting.front().is_long && running_long_ >= max_long_) continue;
      if (next == clients_.end() || order_of(at->second) < order_of(next->second)) next = at;
    }
    if (next == clients_.end()) return std::nullopt;
    Served& served = next->second;
    Taken taken{next->first, std::move(served.waiting.front())};
    served.waiting.pop_front();
    --waiting_;
    ++served.running;
    now_ = std::max(now_, served.seconds);
    if (taken.job.is_long) ++running_long_;
    return taken;
  }

  // The job of `client` has run for `seconds`.
  void done(Client client, bool is_long, double seconds) {
    if (is_long) --running_long_;
    const auto at = clients_.find(client);
    Served& served = at->second;
    --served.running;
    served.seconds += seconds;
    // An idle client is remembered as long as it is ahead of the others.
    std::erase_if(clients_, [this](const auto& entry) {
      const Served& s = entry.second;
      return s.waiting.empty() && s.running == 0 && s.seconds <= now_;
    });
  }

  [[nodiscard]] std::size_t waiting() const { return waiting_; }

 private:
  struct Served {
    double seconds = 0;
    std::size_t running = 0;
    std::deque<Job> waiting;
  };
  // Requires a job that waits.
  [[nodiscard]] static std::pair<bool, double> order_of(const Served& client) {
    return {client.waiting.front().is_background, client.seconds};
  }

  std::size_t max_long_;
  std::size_t running_long_ = 0;
  std::size_t waiting_ = 0;
  double now_ = 0;  // The largest time served at which a job was taken.
  std::map<Client, Served> clients_;
};

}  // namespace multitetra

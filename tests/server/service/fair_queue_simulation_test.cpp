// The fair queue in simulated time: how long clients wait among many others.
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/service/fair_queue.hpp"

namespace multitetra {
namespace {

std::string numbered(const char* format, int number) {
  char text[64];
  std::snprintf(text, sizeof text, format, number);
  return text;
}

// Workers that take jobs from a queue. A job takes its expected time, or the given actual time,
// then `run` is called. Its pieces are shorter than kCheck, so it may pause at each check.
class SimulatedWorkers {
 public:
  explicit SimulatedWorkers(std::size_t workers) : workers_(workers), queue_(workers - 1) {}

  void add(
      const FairQueue::Client& client, double seconds, std::function<void()> when_done = [] {},
      double expected = 0) {
    if (expected == 0) expected = seconds;
    queue_.add(client, {.run = std::move(when_done),
                        .is_long = expected > FairQueue::kLongSeconds,
                        .kind = numbered("%d ms", static_cast<int>(1000 * seconds)),
                        .expected_seconds = expected});
    take();
  }
  // Completes all jobs that end by `time`, including those added meanwhile.
  void run_until(double time) {
    constexpr double kCheck = 0.05;
    while (!running_.empty()) {
      const double next_check = now_ + kCheck;
      const auto first = running_.begin();
      if (std::min(first->first, next_check) > time) break;
      if (first->first > next_check) {
        now_ = next_check;
        note_overdue();
        pause_overtaken();
      } else {
        now_ = first->first;
        const Running done = std::move(first->second);
        running_.erase(first);
        queue_.done(done.taken, now_ - done.start);
        done.taken.job.run();
        resume_paused();
      }
      take();
    }
    now_ = time;
  }
  [[nodiscard]] double now() const { return now_; }

 private:
  struct Running {
    FairQueue::DequeuedJob taken;
    double start;
  };
  void take() {
    while (running_.size() < workers_ + std::min(queue_.excess_long(), workers_)) {
      auto taken = queue_.take();
      if (!taken) return;
      const double seconds = std::stod(taken->job.kind) / 1000;
      running_.emplace(now_ + seconds, Running{*std::move(taken), now_});
    }
  }
  void note_overdue() {
    for (auto& [end, one] : running_) {
      const double seconds = now_ - one.start;
      const double expected = one.taken.job.expected_seconds;
      if (!one.taken.job.is_long && seconds > 0.25 && seconds > 2 * expected) {
        queue_.overdue(one.taken, seconds);
      }
    }
  }

  void pause_overtaken() {
    for (auto at = running_.begin(); at != running_.end();) {
      Running& one = at->second;
      if (paused_.size() < workers_ && queue_.should_pause(one.taken)) {
        queue_.paused(one.taken);
        paused_.emplace_back(at->first - now_, std::move(one));
        paused_.back().second.start -= now_;
        at = running_.erase(at);
        take();
      } else {
        ++at;
      }
    }
  }
  void resume_paused() {
    for (auto at = paused_.begin(); at != paused_.end();) {
      auto& [remaining, one] = *at;
      if (queue_.should_resume(one.taken)) {
        queue_.resumed(one.taken);
        one.start += now_;
        running_.emplace(now_ + remaining, std::move(one));
        at = paused_.erase(at);
      } else {
        ++at;
      }
    }
  }

  std::size_t workers_;
  FairQueue queue_;
  std::vector<std::pair<double, Running>> paused_;  // With the remaining time; starts before 0.
  std::multimap<double, Running> running_;          // By end time.
  double now_ = 0;
};

// A client that requests one surface after another, each a preview and a final step.
class Stream {
 public:
  // The final step is expected to take `expected_final`; 0: what it takes.
  Stream(SimulatedWorkers& workers, FairQueue::Client client, double preview, double final_step,
         double expected_final = 0)
      : workers_(workers),
        client_(std::move(client)),
        preview_(preview),
        final_(final_step),
        expected_final_(expected_final) {}
  void start() {
    began_ = workers_.now();
    workers_.add(client_, preview_, [this] {
      workers_.add(
          client_, final_,
          [this] {
            seconds_.push_back(workers_.now() - began_);
            start();
          },
          expected_final_);
    });
  }
  // Seconds from the request of each surface to its completion.
  [[nodiscard]] const std::vector<double>& seconds() const { return seconds_; }

 private:
  SimulatedWorkers& workers_;
  FairQueue::Client client_;
  double preview_, final_, expected_final_;
  double began_ = 0;
  std::vector<double> seconds_;
};

using Streams = std::vector<std::unique_ptr<Stream>>;

Streams started(SimulatedWorkers& workers, int count, const char* share, double final_step,
                double expected_final = 0) {
  Streams streams;
  for (int i = 0; i < count; ++i) {
    streams.push_back(std::make_unique<Stream>(
        workers, FairQueue::Client{numbered(share, i), static_cast<std::uint64_t>(i)}, 0.02,
        final_step, expected_final));
    streams.back()->start();
  }
  return streams;
}

TEST(FairQueueSimulation, CompletesASmallSurfaceWithinASecondBesideTwoHundredLongOnes) {
  for (const double final_step : {2.0, 0.4}) {
    for (const double later : {5.0, 60.0}) {
      SimulatedWorkers workers(3);
      const Streams long_ones = started(workers, 200, "address 192.0.2.%d", final_step);
      workers.run_until(later);
      Stream small(workers, {"address 198.51.100.1", 1000}, 0.02, 0.02);
      small.start();
      workers.run_until(later + 1);
      EXPECT_GE(small.seconds().size(), 1U) << final_step << " s, after " << later << " s";
    }
  }
}

TEST(FairQueueSimulation, CompletesASmallSurfaceBesideLongOnesThatWereExpectedToBeShort) {
  for (const double later : {3.0, 5.0, 20.0}) {
    SimulatedWorkers workers(3);
    const Streams long_ones = started(workers, 200, "address 192.0.2.%d", 20.0, 0.08);
    workers.run_until(later);
    Stream small(workers, {"address 198.51.100.1", 1000}, 0.02, 0.02);
    small.start();
    workers.run_until(later + 1);
    EXPECT_GE(small.seconds().size(), 1U) << "after " << later << " s";
  }
}

TEST(FairQueueSimulation, CompletesAStepOfASecondBesideTwoHundredOfAMinute) {
  for (const double later : {5.0, 50.0, 70.0}) {
    SimulatedWorkers workers(3);
    const Streams long_ones = started(workers, 200, "address 192.0.2.%d", 60.0);
    workers.run_until(later);
    Stream medium(workers, {"address 198.51.100.1", 1000}, 0.02, 1.0);
    medium.start();
    workers.run_until(later + 2);
    EXPECT_GE(medium.seconds().size(), 1U) << "after " << later << " s";
  }
}

TEST(FairQueueSimulation, CompletesStepsThatOthersOvertake) {
  SimulatedWorkers workers(3);
  const Streams medium_ones = started(workers, 30, "address 192.0.2.%d", 0.6);
  Stream large(workers, {"address 198.51.100.1", 1000}, 0.02, 20.0);
  large.start();
  // Each of 31 shares gets 2/31 of the time of two workers: 20 s of work take 310 s.
  workers.run_until(400);
  EXPECT_GE(large.seconds().size(), 1U);
}

TEST(FairQueueSimulation, CompletesLongStepsDespiteManyShortOnes) {
  SimulatedWorkers workers(3);
  const Streams small_ones = started(workers, 50, "address 192.0.2.%d", 0.02);
  Stream large(workers, {"address 198.51.100.1", 1000}, 0.02, 2.0);
  large.start();
  // Each of 51 shares gets 3/51 of the time of three workers: 2 s of work take 34 s.
  workers.run_until(45);
  EXPECT_GE(large.seconds().size(), 1U);
}

TEST(FairQueueSimulation, GivesSubnetsOfAnIpv6NetworkNoMoreThanAFewAddresses) {
  SimulatedWorkers workers(3);
  const Streams of_one_site = started(workers, 64, "address 2001:db8:1:%x::/64", 0.1);
  const Streams of_addresses = started(workers, 4, "address 192.0.2.%d", 0.1);
  workers.run_until(30);
  const auto made = [](const Streams& streams) {
    std::size_t count = 0;
    for (const auto& stream : streams) count += stream->seconds().size();
    return static_cast<double>(count);
  };
  // A /56 counts as two addresses.
  EXPECT_NEAR(made(of_one_site) / made(of_addresses), 0.5, 0.1);
}

}  // namespace
}  // namespace multitetra

// The order in which jobs are served, and the threads that run them.
#include "server/service/workers.hpp"

#include <atomic>
#include <future>
#include <map>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "common/base/in_parallel.hpp"
#include "common/base/yielding.hpp"

namespace multitetra {
namespace {

FairQueue::Job short_job() {
  return {.run = [] {}};
}
FairQueue::Job long_job() {
  return {.run = [] {}, .is_long = true};
}

// `alone` has a share of its own; all `together` clients have a common share.
FairQueue::Client alone(std::uint64_t number) {
  return {"share " + std::to_string(number), number};
}
FairQueue::Client together(std::uint64_t number) { return {"one share", number}; }

// Runs all jobs in order; one of client c takes seconds[c]. Returns the clients in that order.
std::string order_of_service(FairQueue& queue, const std::map<std::uint64_t, double>& seconds) {
  std::string order;
  while (const auto taken = queue.take()) {
    order += static_cast<char>('a' + taken->client.number);
    queue.done(*taken, seconds.at(taken->client.number));
  }
  return order;
}
// Takes the next job, finishes it after `seconds`, and returns its client.
std::uint64_t serve_next(FairQueue& queue, double seconds) {
  const auto taken = queue.take();
  queue.done(*taken, seconds);
  return taken->client.number;
}

TEST(FairQueue, AlternatesClients) {
  FairQueue queue(1);
  for (int i = 0; i < 3; ++i) queue.add(alone(0), short_job());
  for (int i = 0; i < 3; ++i) queue.add(alone(1), short_job());
  EXPECT_EQ(order_of_service(queue, {{0, 1.0}, {1, 1.0}}), "ababab");
}

TEST(FairQueue, DividesTimeRatherThanJobs) {
  FairQueue queue(1);
  for (int i = 0; i < 3; ++i) queue.add(alone(0), short_job());
  for (int i = 0; i < 12; ++i) queue.add(alone(1), short_job());
  const std::string order = order_of_service(queue, {{0, 4.0}, {1, 1.0}});
  EXPECT_EQ(std::count(order.begin(), order.begin() + 6, 'a'), 2) << order;
}

TEST(FairQueue, ServesANewClientNext) {
  FairQueue queue(1);
  for (int i = 0; i < 100; ++i) queue.add(alone(0), short_job());
  for (int i = 0; i < 10; ++i) serve_next(queue, 1.0);
  queue.add(alone(1), short_job());
  EXPECT_EQ(queue.take()->client.number, 1U);
}

FairQueue::Job background_job(bool is_long = false) {
  return {.run = [] {}, .is_long = is_long, .is_background = true};
}

TEST(FairQueue, RunsBackgroundJobsLast) {
  FairQueue queue(2);
  for (int i = 0; i < 2; ++i) queue.add(alone(0), background_job());
  for (int i = 0; i < 3; ++i) queue.add(alone(1), short_job());
  for (int i = 0; i < 2; ++i) queue.add(alone(2), long_job());
  EXPECT_EQ(order_of_service(queue, {{0, 0.01}, {1, 1.0}, {2, 5.0}}), "bcbbcaa");
}

TEST(FairQueue, RunsBackgroundJobsOnIdleWorkers) {
  FairQueue queue(1);
  queue.add(alone(0), long_job());
  queue.add(alone(1), long_job());
  queue.add(alone(2), background_job());
  queue.add(alone(3), background_job(/*is_long=*/true));
  EXPECT_EQ(queue.take()->client.number, 0U);
  EXPECT_EQ(queue.take()->client.number, 2U) << "no other long one may run now";
  EXPECT_FALSE(queue.take());
}

TEST(FairQueue, GrantsNoCreditForIdleTime) {
  FairQueue queue(1);
  queue.add(alone(1), short_job());
  serve_next(queue, 0.001);
  for (int i = 0; i < 100; ++i) queue.add(alone(0), short_job());
  for (int i = 0; i < 50; ++i) serve_next(queue, 1.0);
  for (int i = 0; i < 50; ++i) queue.add(alone(1), short_job());
  std::string order;
  for (int i = 0; i < 10; ++i) {
    order += serve_next(queue, 1.0) == 0 ? 'a' : 'b';
  }
  EXPECT_LE(std::count(order.begin(), order.end(), 'b'), 6) << order;
}

TEST(FairQueue, LeavesWorkersToShortJobs) {
  FairQueue queue(1);
  queue.add(alone(0), long_job());
  queue.add(alone(1), long_job());
  queue.add(alone(2), short_job());
  const auto first = queue.take();
  ASSERT_EQ(first->client.number, 0U);
  EXPECT_EQ(queue.take()->client.number, 2U);
  EXPECT_FALSE(queue.take());
  EXPECT_EQ(queue.waiting(), 1U);
  queue.done(*first, 1.0);
  EXPECT_EQ(queue.take()->client.number, 1U);
}

TEST(FairQueue, KeepsTheOrderOfOneClient) {
  FairQueue queue(1);
  std::string done;
  for (char c = 'a'; c <= 'e'; ++c) queue.add(alone(3), {.run = [&done, c] { done += c; }});
  while (auto taken = queue.take()) {
    taken->job.run();
    queue.done(*taken, 1.0);
  }
  EXPECT_EQ(done, "abcde");
}

// ---- shares

TEST(FairQueue, GivesSharesOfManyClientsNoMoreTime) {
  FairQueue queue(1);
  for (std::uint64_t client = 1; client <= 20; ++client) {
    for (int i = 0; i < 5; ++i) queue.add(together(client), short_job());
  }
  for (int i = 0; i < 5; ++i) queue.add(alone(0), short_job());
  int of_one = 0;
  for (int i = 0; i < 10; ++i) of_one += serve_next(queue, 1.0) == 0 ? 1 : 0;
  EXPECT_EQ(of_one, 5);
}

TEST(FairQueue, AlternatesClientsOfAShare) {
  FairQueue queue(1);
  for (int i = 0; i < 3; ++i) queue.add(together(0), short_job());
  for (int i = 0; i < 3; ++i) queue.add(together(1), short_job());
  EXPECT_EQ(order_of_service(queue, {{0, 1.0}, {1, 1.0}}), "ababab");
}

TEST(FairQueue, LeavesWorkersToOtherShares) {
  FairQueue queue(3);
  for (std::uint64_t client = 1; client <= 20; ++client) {
    queue.add(together(client), long_job());
    queue.add(together(client), short_job());
    queue.add(together(100 + client), short_job());
  }
  EXPECT_TRUE(queue.take()->job.is_long);
  EXPECT_FALSE(queue.take()->job.is_long);
  EXPECT_FALSE(queue.take()) << "two of a share run";
  queue.add(alone(0), long_job());
  EXPECT_EQ(queue.take()->client.number, 0U) << "and another one's long job beside them";
}

TEST(FairQueue, ChargesTheExpectedTimeWhenAJobStarts) {
  FairQueue queue(1);
  const auto costing = [](double seconds) {
    return FairQueue::Job{.run = [] {}, .expected_seconds = seconds};
  };
  queue.add(alone(0), costing(10));
  queue.add(alone(0), costing(10));
  const auto first = queue.take();
  ASSERT_EQ(first->client.number, 0U);
  queue.add(alone(1), costing(1));
  queue.add(alone(1), costing(1));
  EXPECT_EQ(serve_next(queue, 1.0), 1U);
  EXPECT_EQ(serve_next(queue, 1.0), 1U) << "the first one's job still runs";
  EXPECT_EQ(queue.expected_seconds(alone(0).share), 20);
  queue.done(*first, 0.1);
  EXPECT_EQ(queue.expected_seconds(alone(0).share), 10);
  EXPECT_EQ(queue.expected_seconds(alone(1).share), 0);
}

TEST(FairQueue, ForgetsIdleClients) {
  FairQueue queue(1);
  for (std::uint64_t client = 0; client < 100; ++client) queue.add(alone(client), short_job());
  for (int i = 0; i < 100; ++i) serve_next(queue, 1.0);
  EXPECT_EQ(queue.busy_shares(), 0U);
  EXPECT_EQ(queue.waiting(), 0U);
}

TEST(FairQueue, PausesALongJobForOneThatIsDueBeforeIt) {
  const auto lasting = [](double seconds) {
    return FairQueue::Job{.run = [] {}, .is_long = true, .expected_seconds = seconds};
  };
  FairQueue queue(1);
  queue.add(alone(0), lasting(60));
  const auto first = queue.take();
  EXPECT_FALSE(queue.should_pause(*first)) << "nobody waits";
  queue.add(alone(0), lasting(1));
  queue.add(alone(1), lasting(60));
  queue.add(alone(2), short_job());
  EXPECT_FALSE(queue.should_pause(*first)) << "of its own share, of its length, and short";
  queue.add(alone(3), lasting(1));
  EXPECT_TRUE(queue.should_pause(*first));
  queue.paused(*first);
  EXPECT_FALSE(queue.should_resume(*first));
  EXPECT_EQ(queue.take()->client.number, 2U);
  const auto second = queue.take();
  ASSERT_EQ(second->client.number, 3U);
  EXPECT_FALSE(queue.should_resume(*first));
  EXPECT_FALSE(queue.take());
  queue.done(*second, 1);
  EXPECT_TRUE(queue.should_resume(*first));
  queue.resumed(*first);
  EXPECT_FALSE(queue.take()) << "it has its place again";
}

// Pieces of a millisecond until `is_over`.
Work in_pieces(double seconds, std::function<bool()> is_over, std::function<void()> done) {
  const auto run = [is_over = std::move(is_over), done = std::move(done)] {
    in_parallel(20'000, [&](std::size_t) {
      if (!is_over()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    done();
  };
  return {.run = run, .is_long = true, .forecast = [seconds] { return seconds; }};
}

TEST(Workers, PauseALongJobBetweenItsPiecesForAShorterOne) {
  Workers workers(2);
  std::atomic<bool> has_begun = false;
  std::atomic<bool> has_ended = false;
  std::promise<double> paused;
  Work longer = in_pieces(
      60,
      [&] {
        has_begun = true;
        return has_ended.load();
      },
      [] {});
  const auto time = longer.time = std::make_shared<WorkTime>();
  workers.post(alone(0), std::move(longer));
  while (!has_begun) std::this_thread::yield();
  workers.post(alone(1), in_pieces(
                             1, [] { return true; },
                             [&] {
                               const double before = time->seconds();
                               std::this_thread::sleep_for(std::chrono::milliseconds(20));
                               paused.set_value(time->seconds() - before);
                             }));
  auto shorter = paused.get_future();
  ASSERT_EQ(shorter.wait_for(std::chrono::seconds(5)), std::future_status::ready);
  EXPECT_EQ(shorter.get(), 0) << "the pause counts as time of the job";
  EXPECT_GT(time->seconds(), 0);
  has_ended = true;
  workers.join();
}

// The shorter job waits for the longer one, as for a surface that both make.
TEST(Workers, ResumeAJobThatOthersWaitFor) {
  Workers workers(2);
  std::atomic<bool> has_begun = false;
  std::atomic<bool> may_end = false;
  std::promise<void> longer_has_ended;
  const auto ended = longer_has_ended.get_future().share();
  workers.post(alone(0), in_pieces(
                             60,
                             [&] {
                               has_begun = true;
                               return may_end.load();
                             },
                             [&] { longer_has_ended.set_value(); }));
  while (!has_begun) std::this_thread::yield();
  workers.post(alone(1), {.run =
                              [&] {
                                may_end = true;
                                ended.wait();
                              },
                          .is_long = true,
                          .forecast = [] { return 1.0; }});
  EXPECT_EQ(ended.wait_for(std::chrono::seconds(20)), std::future_status::ready);
  workers.join();
}

TEST(Workers, GiveAwayThePlaceOfALongJobThatWaitsForAnother) {
  Workers workers(2);  // One place for long jobs.
  std::promise<void> other_has_ended;
  std::promise<bool> result;
  const auto run = [&] {
    const BlockedScope blocked;
    result.set_value(other_has_ended.get_future().wait_for(std::chrono::seconds(20)) ==
                     std::future_status::ready);
  };
  workers.post(alone(0), {.run = run, .is_long = true, .forecast = [] { return 1.0; }});
  workers.post(alone(1), {.run = [&] { other_has_ended.set_value(); },
                          .is_long = true,
                          .forecast = [] { return 60.0; }});
  EXPECT_TRUE(result.get_future().get());
  workers.join();
}

TEST(Workers, RunAllJobsBeforeTheyAreDestroyed) {
  for (const std::size_t threads : {0U, 1U, 3U}) {
    std::atomic<int> ran = 0;
    Workers workers(threads);
    for (int i = 0; i < 100; ++i) {
      workers.post(alone(workers.new_client()), {.run = [&ran] { ++ran; }, .is_long = i % 3 == 0});
    }
    workers.join();
    EXPECT_EQ(ran, 100);
  }
}

TEST(Workers, RunShortJobsBesideLongOnes) {
  Workers workers(2);
  std::promise<void> release;
  const auto released = release.get_future().share();
  for (int i = 0; i < 3; ++i) {
    workers.post(alone(workers.new_client()),
                 {.run = [released] { released.wait(); }, .is_long = true});
  }
  std::promise<void> ran;
  workers.post(alone(workers.new_client()), {.run = [&ran] { ran.set_value(); }});
  EXPECT_EQ(ran.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  release.set_value();
  workers.join();
}

}  // namespace
}  // namespace multitetra

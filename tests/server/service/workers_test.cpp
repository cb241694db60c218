// The order in which jobs are served, and the threads that run them.
#include "server/service/workers.hpp"

#include <atomic>
#include <future>
#include <map>
#include <string>

#include <gtest/gtest.h>

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

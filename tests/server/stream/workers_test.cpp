// Who is served next, and the threads that do it.
#include "server/stream/workers.hpp"

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

// Takes and finishes jobs one after another; job k of client c takes seconds[c].
std::string order_of_service(FairQueue& queue, const std::map<FairQueue::Client, double>& seconds) {
  std::string order;
  while (const auto taken = queue.take()) {
    order += static_cast<char>('a' + taken->client);
    queue.done(taken->client, taken->job.is_long, seconds.at(taken->client));
  }
  return order;
}

TEST(FairQueue, ServesClientsInTurn) {
  FairQueue queue(1);
  for (int i = 0; i < 3; ++i) queue.add(0, short_job());
  for (int i = 0; i < 3; ++i) queue.add(1, short_job());
  EXPECT_EQ(order_of_service(queue, {{0, 1.0}, {1, 1.0}}), "ababab");
}

TEST(FairQueue, GivesTheSameTimeNotTheSameNumberOfJobs) {
  FairQueue queue(1);
  for (int i = 0; i < 3; ++i) queue.add(0, short_job());
  for (int i = 0; i < 12; ++i) queue.add(1, short_job());
  const std::string order = order_of_service(queue, {{0, 4.0}, {1, 1.0}});
  EXPECT_EQ(std::count(order.begin(), order.begin() + 6, 'a'), 2) << order;
}

TEST(FairQueue, ANewClientIsServedNextHoweverMuchOthersWant) {
  FairQueue queue(1);
  for (int i = 0; i < 100; ++i) queue.add(0, short_job());
  for (int i = 0; i < 10; ++i) queue.done(queue.take()->client, false, 1.0);
  queue.add(1, short_job());
  EXPECT_EQ(queue.take()->client, 1U);
}

FairQueue::Job background_job(bool is_long = false) {
  return {.run = [] {}, .is_long = is_long, .is_background = true};
}

TEST(FairQueue, WhatIsInTheBackgroundComesLastWhoeverAsks) {
  FairQueue queue(2);
  for (int i = 0; i < 2; ++i) queue.add(0, background_job());
  for (int i = 0; i < 3; ++i) queue.add(1, short_job());
  for (int i = 0; i < 2; ++i) queue.add(2, long_job());
  EXPECT_EQ(order_of_service(queue, {{0, 0.01}, {1, 1.0}, {2, 5.0}}), "bcbbcaa");
}

TEST(FairQueue, WhatIsInTheBackgroundIsDoneWhereNothingElseCouldBe) {
  FairQueue queue(1);
  queue.add(0, long_job());
  queue.add(1, long_job());
  queue.add(2, background_job());
  queue.add(3, background_job(/*is_long=*/true));
  EXPECT_EQ(queue.take()->client, 0U);
  EXPECT_EQ(queue.take()->client, 2U) << "no other long one may run now";
  EXPECT_FALSE(queue.take());
}

TEST(FairQueue, BeingIdleSavesNothingUp) {
  FairQueue queue(1);
  queue.add(1, short_job());
  queue.done(queue.take()->client, false, 0.001);
  for (int i = 0; i < 100; ++i) queue.add(0, short_job());
  for (int i = 0; i < 50; ++i) queue.done(queue.take()->client, false, 1.0);
  for (int i = 0; i < 50; ++i) queue.add(1, short_job());
  std::string order;
  for (int i = 0; i < 10; ++i) {
    const auto taken = queue.take();
    order += taken->client == 0 ? 'a' : 'b';
    queue.done(taken->client, false, 1.0);
  }
  EXPECT_LE(std::count(order.begin(), order.end(), 'b'), 6) << order;
}

TEST(FairQueue, LongJobsLeaveRoomForShortOnes) {
  FairQueue queue(1);
  queue.add(0, long_job());
  queue.add(1, long_job());
  queue.add(2, short_job());
  ASSERT_EQ(queue.take()->client, 0U);
  EXPECT_EQ(queue.take()->client, 2U);
  EXPECT_FALSE(queue.take());
  EXPECT_EQ(queue.waiting(), 1U);
  queue.done(0, true, 1.0);
  EXPECT_EQ(queue.take()->client, 1U);
}

TEST(FairQueue, KeepsTheOrderOfOneClient) {
  FairQueue queue(1);
  std::string done;
  for (char c = 'a'; c <= 'e'; ++c) queue.add(3, {.run = [&done, c] { done += c; }});
  while (auto taken = queue.take()) {
    taken->job.run();
    queue.done(taken->client, false, 1.0);
  }
  EXPECT_EQ(done, "abcde");
}

TEST(Workers, RunEverythingBeforeTheyEnd) {
  for (const std::size_t threads : {0U, 1U, 3U}) {
    std::atomic<int> ran = 0;
    Workers workers(threads);
    for (int i = 0; i < 100; ++i) {
      workers.post(workers.new_client(), {.run = [&ran] { ++ran; }, .is_long = i % 3 == 0});
    }
    workers.join();
    EXPECT_EQ(ran, 100);
  }
}

TEST(Workers, AShortJobRunsBesideALongOne) {
  Workers workers(2);
  std::promise<void> release;
  const auto released = release.get_future().share();
  for (int i = 0; i < 3; ++i) {
    workers.post(workers.new_client(), {.run = [released] { released.wait(); }, .is_long = true});
  }
  std::promise<void> ran;
  workers.post(workers.new_client(), {.run = [&ran] { ran.set_value(); }});
  EXPECT_EQ(ran.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  release.set_value();
  workers.join();
}

}  // namespace
}  // namespace multitetra

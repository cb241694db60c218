#include "server/programs/serving/coalescing_task.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <semaphore>

namespace multitetra {
namespace {

TEST(CoalescingTask, RunsOncePerRequest) {
  std::counting_semaphore<> done(0);
  std::atomic<int> runs = 0;
  {
    CoalescingTask work([&] {
      ++runs;
      done.release();
    });
    for (int i = 0; i < 3; ++i) {
      work.request();
      done.acquire();
    }
  }
  EXPECT_EQ(runs, 3);
}

TEST(CoalescingTask, RunsOnceMoreForRequestsDuringARun) {
  std::latch is_running(1);
  std::latch may_end(1);
  std::counting_semaphore<> done(0);
  std::atomic<int> runs = 0;
  CoalescingTask work([&] {
    if (++runs == 1) {
      is_running.count_down();
      may_end.wait();
    }
    done.release();
  });
  work.request();
  is_running.wait();
  for (int i = 0; i < 5; ++i) work.request();
  may_end.count_down();
  done.acquire();
  done.acquire();
  EXPECT_EQ(runs, 2) << "five queries while it ran are one";
}

TEST(CoalescingTask, WaitsForTheCurrentRunInStop) {
  std::atomic<bool> has_ended = false;
  {
    std::latch is_running(1);
    CoalescingTask work([&] {
      is_running.count_down();
      has_ended = true;
    });
    work.request();
    is_running.wait();
  }
  EXPECT_TRUE(has_ended);
}

}  // namespace
}  // namespace multitetra

#include "common/base/parallel_tree.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <mutex>
#include <random>
#include <stdexcept>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/in_parallel.hpp"
#include "common/base/yielding.hpp"

namespace multitetra {
namespace {

std::vector<std::size_t> random_tree(std::size_t nodes, unsigned seed) {
  std::minstd_rand random(seed);
  std::vector<std::size_t> parents(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const std::size_t last = std::min(nodes - 1, i + 9);
    parents[i] = i + 1 > last ? i : i + 1 + random() % (last - i);
  }
  return parents;
}

TEST(InParallelUpwards, CallsEveryNodeOnceAfterItsChildren) {
  for (const std::size_t nodes : {1U, 2U, 3U, 10U, 500U}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const std::vector<std::size_t> parents = random_tree(nodes, seed);
      std::mutex mutex;
      std::vector<int> calls(nodes, 0);
      std::vector<bool> has_ended(nodes, false);
      in_parallel_upwards(parents, [&](std::size_t node) {
        const std::lock_guard lock(mutex);
        ++calls[node];
        for (std::size_t child = 0; child < node; ++child) {
          EXPECT_TRUE(parents[child] != node || has_ended[child]) << child << " of " << node;
        }
        has_ended[node] = true;
      });
      EXPECT_EQ(calls, std::vector<int>(nodes, 1)) << nodes << " nodes, seed " << seed;
    }
  }
  in_parallel_upwards({}, [](std::size_t) { FAIL(); });
}

// Is due after every piece.
class AlwaysDue : public Yields {
 public:
  [[nodiscard]] bool is_due() const override { return has_run; }
  void wait() override {
    EXPECT_EQ(running, 0) << "a piece runs";
    has_run = false;
    ++waits;
  }
  void run_piece() {
    ++running;
    has_run = true;
    --running;
  }

  std::atomic<bool> has_run = false;
  std::atomic<int> running = 0;
  int waits = 0;
};

TEST(InParallelUpwards, YieldsBetweenNodes) {
  const std::vector<std::size_t> parents = random_tree(200, 1);
  AlwaysDue yields;
  const YieldScope scope(&yields);
  std::vector<int> calls(200, 0);
  in_parallel_upwards(parents, [&](std::size_t node) {
    ++calls[node];
    yields.run_piece();
  });
  EXPECT_EQ(calls, std::vector<int>(200, 1));
  EXPECT_GE(yields.waits, 10);
}

TEST(InParallel, YieldsBetweenItsCallsAndNotWithinThem) {
  AlwaysDue yields;
  const YieldScope scope(&yields);
  std::vector<std::atomic<int>> calls(100);
  in_parallel(calls.size(), [&](std::size_t i) {
    in_parallel(2, [&](std::size_t) { ++calls[i]; });
    yields.run_piece();
  });
  for (const std::atomic<int>& count : calls) EXPECT_EQ(count, 2);
  EXPECT_GE(yields.waits, 10);
}

TEST(InParallelUpwards, StartsNoParentAfterAFailure) {
  const std::vector<std::size_t> parents = random_tree(200, 1);
  std::atomic<bool> root_was_called = false;
  const auto fail_at_100 = [&](std::size_t node) {
    if (node == 100) throw std::runtime_error("node 100");
    if (node == 199) root_was_called = true;
  };
  EXPECT_THROW(in_parallel_upwards(parents, fail_at_100), std::runtime_error);
  EXPECT_FALSE(root_was_called);
}

TEST(InParallelUpwards, EndsSoonAfterItIsStopped) {
  const std::vector<std::size_t> parents = random_tree(200, 2);
  std::stop_source stop;
  std::atomic<int> calls = 0;
  const auto stop_after_three = [&](std::size_t) {
    if (++calls == 3) stop.request_stop();
  };
  EXPECT_THROW(in_parallel_upwards(parents, stop_after_three, stop.get_token()), Cancelled);
  EXPECT_LT(calls, 3 + static_cast<int>(parallel_threads()));
}

}  // namespace
}  // namespace multitetra

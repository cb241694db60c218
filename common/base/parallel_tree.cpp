#include "common/base/parallel_tree.hpp"

#include <algorithm>
#include <mutex>
#include <queue>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/base/yielding.hpp"

namespace multitetra {

// Each finished node makes at most one node ready, its parent. So a thread that finds no ready node
// is no longer needed and returns instead of waiting; all return when the loop is to yield.
void in_parallel_upwards(std::span<const std::size_t> parents,
                         const std::function<void(std::size_t)>& body, std::stop_token stop) {
  if (parents.empty()) return;
  const std::size_t root = parents.size() - 1;
  std::mutex mutex;  // Guards all variables below.
  std::vector<std::size_t> children_left(parents.size(), 0);
  std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> ready;
  std::size_t undone = parents.size();
  bool is_failed = false;
  const YieldingLoop loop;
  for (std::size_t i = 0; i < root; ++i) ++children_left[parents[i]];
  for (std::size_t i = 0; i <= root; ++i) {
    if (children_left[i] == 0) ready.push(i);
  }
  const auto work = [&](std::size_t) {
    std::unique_lock lock(mutex);
    while (!is_failed && !ready.empty() && !loop.is_due()) {
      const std::size_t node = ready.top();
      ready.pop();
      lock.unlock();
      try {
        throw_if_stopped(stop);
        body(node);
      } catch (...) {
        lock.lock();
        is_failed = true;
        throw;
      }
      lock.lock();
      --undone;
      if (node != root && --children_left[parents[node]] == 0) ready.push(parents[node]);
    }
  };
  while (undone > 0) {
    in_parallel(std::min(parallel_threads(), ready.size()), work, stop);
    if (undone > 0) loop.wait();
  }
}

}  // namespace multitetra

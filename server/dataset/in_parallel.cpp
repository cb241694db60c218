#include "server/dataset/in_parallel.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace multitetra {

void in_parallel(std::size_t count, const std::function<void(std::size_t)>& body,
                 std::stop_token stop) {
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (stop.stop_requested()) throw Cancelled{};
      body(i);
    });
  });
}

}  // namespace multitetra

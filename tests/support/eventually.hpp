// Waiting for what other threads bring about.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace multitetra::testing {

// Whether it has happened within some seconds.
inline bool eventually(const std::function<bool()>& happened) {
  for (int i = 0; i < 5000; ++i) {
    if (happened()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace multitetra::testing

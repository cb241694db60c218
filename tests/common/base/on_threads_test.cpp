#include "common/base/on_threads.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <stdexcept>

namespace multitetra {
namespace {

TEST(OnThreads, CallsEachOnce) {
  for (const std::size_t threads : {0U, 1U, 3U, 200U}) {
    std::array<std::atomic<int>, 100> calls{};
    on_threads(threads, calls.size(), [&](std::size_t i) { ++calls[i]; });
    for (const auto& count : calls) EXPECT_EQ(count, 1);
  }
  on_threads(2, 0, [](std::size_t) { FAIL() << "There is nothing to call."; });
}

TEST(OnThreads, RethrowsAndBeginsNoFurtherCalls) {
  std::atomic<int> calls = 0;
  const auto body = [&](std::size_t) {
    ++calls;
    throw std::runtime_error("stop");
  };
  EXPECT_THROW(on_threads(3, 1000, body), std::runtime_error);
  EXPECT_LE(calls, 3) << "at most one for each thread";
}

}  // namespace
}  // namespace multitetra

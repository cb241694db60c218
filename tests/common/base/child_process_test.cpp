#include "common/base/child_process.hpp"

#include <gtest/gtest.h>

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using std::chrono::milliseconds;
using testing::expect_contains;

constexpr std::uint64_t kMemory = std::uint64_t{64} << 20;

std::string failure_of(const std::function<std::string()>& work) {
  try {
    (void)run_in_child_process(work, kMemory, milliseconds(500));
  } catch (const std::runtime_error& problem) {
    return problem.what();
  }
  return "made";
}

TEST(ChildProcess, ReceivesMessagesOfTheChild) {
  const std::string large(3'000'000, 'x');
  EXPECT_EQ(run_in_child_process([&] { return large; }, kMemory, milliseconds(5000)), large);
  EXPECT_EQ(run_in_child_process([] { return std::string(); }, kMemory, milliseconds(5000)), "");
}

TEST(ChildProcess, IsolatesCrashesHangsAndMemoryExhaustion) {
  EXPECT_EQ(failure_of([]() -> std::string { throw std::invalid_argument("in words"); }),
            "in words");
  expect_contains(failure_of([]() -> std::string {
                    signal(SIGABRT, SIG_DFL);
                    std::abort();
                  }),
                  "crashed");
  expect_contains(failure_of([]() -> std::string {
                    while (true) std::this_thread::sleep_for(milliseconds(50));
                  }),
                  "timed out");
  expect_contains(failure_of([]() -> std::string { _exit(3); }), "its reader failed");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  expect_contains(failure_of([] {
                    std::vector<char> much(std::size_t{1} << 30, 'x');
                    return std::string(much.begin(), much.begin() + 1);
                  }),
                  "not enough memory");
#endif
}

TEST(ChildProcess, AnswersRepeatedRequests) {
  ChildProcess child(
      [](ChildChannel& parent) {
        ChildMessage message;
        while (parent.receive(message, milliseconds(5000))) parent.send('a', message.bytes + "!");
      },
      kMemory);
  ChildMessage answer;
  for (const std::string word : {"one", "two"}) {
    ASSERT_TRUE(child.channel().send('q', word));
    ASSERT_TRUE(child.channel().receive(answer, milliseconds(5000)));
    EXPECT_EQ(answer.bytes, word + "!");
  }
}

}  // namespace
}  // namespace multitetra

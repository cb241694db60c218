#include "common/sandbox/channel.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

using std::chrono::milliseconds;

TEST(SandboxChannel, GivesUpOnAMessageByteByByte) {
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  SandboxChannel channel(ends[0]);
  const std::jthread other([&](const std::stop_token& stop) {
    const char byte = 0;
    while (!stop.stop_requested() && ::send(ends[1], &byte, 1, MSG_NOSIGNAL) == 1) {
      std::this_thread::sleep_for(milliseconds(20));
    }
    close(ends[1]);
  });
  SandboxMessage message;
  EXPECT_FALSE(channel.receive(message, milliseconds(100)));
}

}  // namespace
}  // namespace multitetra

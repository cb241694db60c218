#include "common/sandbox/channel.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace multitetra {
namespace {

constexpr std::size_t kHeadBytes = 9;  // The kind and the length.

}  // namespace

SandboxChannel::~SandboxChannel() { close(descriptor_); }

bool SandboxChannel::send(char kind, std::string_view bytes) {
  std::array<char, kHeadBytes> head{};
  const auto length = static_cast<std::uint64_t>(bytes.size());
  head[0] = kind;
  std::memcpy(head.data() + 1, &length, sizeof(length));
  for (std::string_view part : {std::string_view(head.data(), head.size()), bytes}) {
    while (!part.empty()) {
      const ssize_t sent = ::send(descriptor_, part.data(), part.size(), MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent <= 0) return false;
      part.remove_prefix(static_cast<std::size_t>(sent));
    }
  }
  return true;
}

// Single bytes do not prolong the wait: all must arrive within the timeout, and a second for each
// megabyte.
bool SandboxChannel::read(std::span<std::byte> into, std::chrono::milliseconds timeout) const {
  using std::chrono::milliseconds;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + timeout + milliseconds(into.size() >> 10);
  while (!into.empty()) {
    const auto remaining = std::chrono::ceil<milliseconds>(end - Clock::now());
    if (remaining <= milliseconds(0)) return false;
    constexpr milliseconds kMostAtOnce = std::chrono::hours(24);
    pollfd waiting = {.fd = descriptor_, .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min(remaining, kMostAtOnce).count()));
    if (ready < 0 && errno == EINTR) continue;
    if (ready < 0) return false;
    if (ready == 0) continue;
    const ssize_t got = recv(descriptor_, into.data(), into.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

bool SandboxChannel::receive(SandboxMessage& message, std::chrono::milliseconds timeout,
                             std::uint64_t max_bytes) {
  std::array<std::byte, kHeadBytes> head{};
  message.kind = 0;
  if (!read(head, timeout)) return false;
  std::uint64_t length = 0;
  std::memcpy(&length, head.data() + 1, sizeof(length));
  if (length > max_bytes) return false;
  message.bytes.resize(length);
  if (!read(std::as_writable_bytes(std::span(message.bytes)), timeout)) return false;
  message.kind = static_cast<char>(head[0]);
  return true;
}

bool SandboxChannel::receive_into(char kind, std::span<std::byte> into, SandboxMessage& other,
                                  std::chrono::milliseconds timeout) {
  std::array<std::byte, kHeadBytes> head{};
  other.kind = 0;
  if (!read(head, timeout)) return false;
  std::uint64_t length = 0;
  std::memcpy(&length, head.data() + 1, sizeof(length));
  if (static_cast<char>(head[0]) == kind && length == into.size()) return read(into, timeout);
  if (length > std::uint64_t{1} << 24) return false;
  other.bytes.resize(length);
  if (!read(std::as_writable_bytes(std::span(other.bytes)), timeout)) return false;
  other.kind = static_cast<char>(head[0]);
  return false;
}

}  // namespace multitetra

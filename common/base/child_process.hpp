// Runs code on untrusted bytes in a separate process with bounded memory and time. A crash, a hang
// or excessive memory use of the child becomes an error in the parent.
//
//   ChildProcess child([](ChildChannel& parent) { parent.send('h', header_of(file)); }, limits);
//   const ChildMessage message = child.receive(std::chrono::seconds(30));
//
// The child is a fork: it has a copy of the parent's memory and one thread, and must end by
// returning. Its standard output and error are discarded.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace multitetra {

// The child ended, or was killed, before it replied. The text contains the reason: "it crashed
// (Segmentation fault)".
class ChildProcessError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ChildMessage {
  char kind = 0;
  std::string bytes;
};

// One end of a pair of connected sockets. A message consists of kind, length and bytes.
class ChildChannel {
 public:
  explicit ChildChannel(int descriptor) : descriptor_(descriptor) {}
  ~ChildChannel();
  ChildChannel(const ChildChannel&) = delete;
  ChildChannel& operator=(const ChildChannel&) = delete;

  // Returns false if the other end is closed.
  bool send(char kind, std::string_view bytes);
  // Returns false if the other end is closed, sends nothing for `timeout`, or announces a message
  // of more than `max_bytes` bytes.
  bool receive(ChildMessage& message, std::chrono::milliseconds timeout,
               std::uint64_t max_bytes = std::uint64_t{1} << 24);
  // Receives the bytes of a message of this kind and exactly this length without a copy. Returns
  // false after a message of another kind or length, which is stored in `other`, and if no message
  // arrives (other.kind is then 0).
  bool receive_into(char kind, std::span<std::byte> into, ChildMessage& other,
                    std::chrono::milliseconds timeout);

 private:
  bool read(std::span<std::byte> into, std::chrono::milliseconds timeout) const;

  int descriptor_;
};

class ChildProcess {
 public:
  // `memory_bytes` is the child's limit beyond the parent's memory at the fork; the child can
  // change it with set_memory_limit(). Throws ChildProcessError if no process can be created.
  ChildProcess(const std::function<void(ChildChannel&)>& body, std::uint64_t memory_bytes);
  // Kills the child if it is still running.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] ChildChannel& channel() { return channel_; }

  // Throws the reason why the child does not answer; kills it first if necessary.
  [[noreturn]] void throw_exit_reason();

 private:
  // Takes both ends, which must be created before the fork.
  ChildProcess(const std::function<void(ChildChannel&)>& body, std::uint64_t memory_bytes,
               std::array<int, 2> ends);

  int id_ = 0;
  ChildChannel channel_;
};

// Runs `work` in a child process limited to `memory_bytes` and `time`, and returns its result.
// Rethrows exceptions of `work` as std::runtime_error with the same text. Throws ChildProcessError
// if the child crashes or exceeds its time.
[[nodiscard]] std::string run_in_child_process(const std::function<std::string()>& work,
                                               std::uint64_t memory_bytes,
                                               std::chrono::milliseconds time);

// Limits the memory of this process to its current use plus `more_bytes`. Call in the child.
void set_memory_limit(std::uint64_t more_bytes);

}  // namespace multitetra

// Runs code on untrusted bytes in a process of its own, with bounded memory and time. A crash, a
// hang or excessive memory there is an error here.
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

// One end of a pair of connected sockets. A message is its kind, its length and its bytes.
class ChildChannel {
 public:
  explicit ChildChannel(int descriptor) : descriptor_(descriptor) {}
  ~ChildChannel();
  ChildChannel(const ChildChannel&) = delete;
  ChildChannel& operator=(const ChildChannel&) = delete;

  // False when the other end is gone.
  bool send(char kind, std::string_view bytes);
  // False when the other end is gone, or is silent for `silence`, or announces more than `most`.
  bool receive(ChildMessage& message, std::chrono::milliseconds silence,
               std::uint64_t most = std::uint64_t{1} << 24);
  // The bytes of a message of this kind and exactly this length, without a copy; a message of
  // another kind or length goes to `other` and the result is false, as it is when nothing comes
  // (then other.kind is 0).
  bool receive_into(char kind, std::span<std::byte> into, ChildMessage& other,
                    std::chrono::milliseconds silence);

 private:
  bool read(std::span<std::byte> into, std::chrono::milliseconds silence) const;

  int descriptor_;
};

class ChildProcess {
 public:
  // `memory_bytes` is what the child may have beyond what the parent has at the fork; the child may
  // change it later with set_memory_limit. Throws ChildProcessError when there is no process to be
  // had.
  ChildProcess(const std::function<void(ChildChannel&)>& body, std::uint64_t memory_bytes);
  // Ends the child if it has not ended.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] ChildChannel& channel() { return channel_; }

  // Throws what happened to a child that does not answer; ends it first if need be.
  [[noreturn]] void fail();

 private:
  // Takes the two ends, for they are made before the fork.
  ChildProcess(const std::function<void(ChildChannel&)>& body, std::uint64_t memory_bytes,
               std::array<int, 2> ends);

  int id_ = 0;
  ChildChannel channel_;
};

// The bytes that `work` returns, from a child process that may have `memory_bytes` and take `time`.
// An exception that it throws is a std::runtime_error with its text here; throws ChildProcessError
// when the child crashes or does not come to an end.
[[nodiscard]] std::string run_in_child_process(const std::function<std::string()>& work,
                                               std::uint64_t memory_bytes,
                                               std::chrono::milliseconds time);

// In the child: what it may have from now on, beyond what it has.
void set_memory_limit(std::uint64_t more_bytes);

}  // namespace multitetra

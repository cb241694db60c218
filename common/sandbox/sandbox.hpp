// Runs a task of this program on untrusted bytes, in a process with the rules of isolation.hpp. A
// crash, a hang or excessive memory use of the task becomes an error.
//
//   const SandboxTask kCount = answering("count words", count_words);
//   std::string answer = run_in_sandbox(kCount, {.readable = {file}}, file.string(), {});
//
// The process is this program, executed again: it has neither the memory, the environment nor the
// descriptors of its parent. So main() must begin with enter_sandbox_if_asked(). A library in a
// program of somebody else names one that does.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/sandbox/channel.hpp"
#include "common/sandbox/isolation.hpp"

namespace multitetra {

// The task ended, or was killed, before it replied. The text contains the reason: "its reader
// crashed (Segmentation fault)".
class SandboxError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The task was killed since it did not reply in time.
class SandboxTimeout : public SandboxError {
 public:
  using SandboxError::SandboxError;
};

// A function that sandboxed processes run, known by its name. Define tasks as globals.
class SandboxTask {
 public:
  // `body` receives further messages of the parent, and ends the process by returning.
  using Body = std::function<void(SandboxChannel& parent, const std::string& request)>;
  SandboxTask(std::string name, Body body);

  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
};

// Returns a task that gives one answer. Its exceptions are sent to the parent.
[[nodiscard]] SandboxTask answering(const std::string& name,
                                    std::function<std::string(const std::string& request)> answer);

// In a process that was started for a task: runs it, and does not return.
void enter_sandbox_if_asked(int argc, char** argv);

// From now on, tasks run in this program, which has them too. Leaves the memory of this process
// readable by others of this user, as its program may need, where tasks are completely isolated.
void use_sandbox_program(std::string program);

// Refuses to run tasks where the kernel cannot isolate them completely.
void require_isolation();

// A process that runs a task.
class Sandbox {
 public:
  // Throws SandboxError if no process can be created or isolated. From now on, other processes of
  // this user cannot read the memory of this one.
  Sandbox(const SandboxTask& task, const SandboxRules& rules, std::string_view request);
  // Kills the process if it is still running.
  ~Sandbox();
  Sandbox(const Sandbox&) = delete;
  Sandbox& operator=(const Sandbox&) = delete;

  // Whatever arrives may have been sent by the untrusted bytes.
  [[nodiscard]] SandboxChannel& channel() { return channel_; }

  // Raises the limit of memory to this many bytes, at most rules.most_memory_bytes.
  void set_memory_limit(std::uint64_t bytes);

  // Throws the reason why the process does not answer; kills it first if necessary.
  [[noreturn]] void throw_exit_reason();

 private:
  Sandbox(const SandboxTask& task, const SandboxRules& rules, std::string_view request,
          std::array<int, 2> ends);
  void stop();

  int id_ = 0;
  std::uint64_t most_memory_bytes_;
  SandboxChannel channel_;
};

// Limits of an answer.
struct AnswerLimits {
  std::chrono::milliseconds time = std::chrono::minutes(2);
  std::uint64_t bytes = std::uint64_t{64} << 20;
};
// Runs an answering() task and returns its answer. Rethrows exceptions of the task as
// std::runtime_error with the same text. Throws SandboxError if it crashes or exceeds its limits.
[[nodiscard]] std::string run_in_sandbox(const SandboxTask& task, const SandboxRules& rules,
                                         std::string_view request, const AnswerLimits& limits = {});

}  // namespace multitetra

#include "common/sandbox/sandbox.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>
#include <new>
#include <utility>

#include "common/base/open_file.hpp"
#include "common/base/printable_line.hpp"
#include "common/sandbox/packed.hpp"

namespace multitetra {
namespace {

constexpr const char* kOption = "--sandboxed-task";
constexpr int kDescriptor = 3;  // Of the channel, in the process of the task.

// Kinds of messages. From the parent: its version, first, as the others may differ between
// versions; the rules and the request. From the task: it is isolated; its answer; the reason of a
// failure.
constexpr char kVersion = 'v';
constexpr char kRules = 'r';
constexpr char kRequest = 'q';
constexpr char kIsolated = 'i';
constexpr char kAnswer = 'a';
constexpr char kFailed = 'f';

constexpr std::chrono::seconds kStartTime{60};
constexpr std::size_t kMaxReasonBytes = 4096;

std::map<std::string, SandboxTask::Body>& tasks() {
  static std::map<std::string, SandboxTask::Body> all;
  return all;
}

// Set by enter_sandbox_if_asked(): without it, each process would run the program again.
std::atomic<bool> can_enter = false;
std::atomic<bool> is_isolation_required = false;

// The program that runs tasks; empty: this one. Set before the first task.
std::string& sandbox_program() {
  static std::string program;
  return program;
}

std::array<int, 2> connected_ends() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw SandboxError(std::string("cannot create a socket pair: ") + std::strerror(errno));
  }
  return ends;
}

// ---- in the new process

[[noreturn]] void run_task(const char* name) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::close_range(kDescriptor + 1, ~0U, 0);
  for (const int signal : {SIGPIPE, SIGINT, SIGHUP, SIGTERM}) ::signal(signal, SIG_IGN);
  SandboxChannel parent(kDescriptor);
  const auto task = tasks().find(name);
  SandboxMessage message;
  SandboxRules rules;
  if (!parent.receive(message, kStartTime) || message.kind != kVersion) ::_exit(1);
  if (message.bytes != MULTITETRA_VERSION) {
    parent.send(kFailed, "is of version " MULTITETRA_VERSION ", but this program is of version " +
                             message.bytes + "; install both from the same build");
    ::_exit(1);
  }
  if (task == tasks().end() || !parent.receive(message, kStartTime) || message.kind != kRules ||
      !unpack_all(message.bytes, rules)) {
    ::_exit(1);
  }
  try {
    isolate(rules);
    if (!parent.send(kIsolated, {}) || !parent.receive(message, kStartTime)) ::_exit(1);
    task->second(parent, message.bytes);
  } catch (const std::exception& problem) {
    parent.send(kFailed, problem.what());
    ::_exit(1);
  }
  ::_exit(0);
}

// ---- in the parent

// The environment of the new process: what requests to other hosts need, or nothing.
std::vector<std::string> environment(bool network) {
  std::vector<std::string> variables;
  if (!network) return variables;
  for (const char* const name :
       {"AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN", "AWS_REGION",
        "AWS_DEFAULT_REGION", "AWS_ENDPOINT_URL", "http_proxy", "https_proxy", "HTTPS_PROXY",
        "all_proxy", "ALL_PROXY", "no_proxy", "NO_PROXY", "SSL_CERT_FILE", "SSL_CERT_DIR",
        "CURL_CA_BUNDLE"}) {
    const char* const value = std::getenv(name);
    if (value != nullptr) variables.push_back(std::string(name) + "=" + value);
  }
  return variables;
}

// Returns the id of the new process, or throws.
pid_t spawn(const std::string& task, bool network, int descriptor) {
  std::string program = "multitetra-sandbox";
  std::string option = kOption;
  std::string name = task;
  std::array<char*, 4> words = {program.data(), option.data(), name.data(), nullptr};
  std::vector<std::string> variables = environment(network);
  std::vector<char*> pointers;
  for (std::string& variable : variables) pointers.push_back(variable.data());
  pointers.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_t actions;
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, descriptor, kDescriptor);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  }
  pid_t id = 0;
  const std::string executed = sandbox_program().empty() ? "/proc/self/exe" : sandbox_program();
  const int error =
      ::posix_spawn(&id, executed.c_str(), &actions, &attributes, words.data(), pointers.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    throw SandboxError(std::string("cannot start a process: ") + std::strerror(error));
  }
  return id;
}

// Prevents other processes of this user, such as a task that is not isolated, from tracing this one
// and from reading its memory. Leak checks trace the process.
void hide_memory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  if (!sandbox_program().empty() && isolation_of_this_kernel().is_complete()) return;
  ::prctl(PR_SET_DUMPABLE, 0);
#endif
}

void check_isolation() {
  const Isolation isolation = isolation_of_this_kernel();
  if (!is_isolation_required || isolation.is_complete()) return;
  throw SandboxError("this system cannot isolate its reader (" + text_of(isolation) +
                     "), and --require-isolation is given");
}

}  // namespace

SandboxTask::SandboxTask(std::string name, Body body) : name_(std::move(name)) {
  tasks().emplace(name_, std::move(body));
}

SandboxTask answering(const std::string& name,
                      std::function<std::string(const std::string& request)> answer) {
  return {name, [answer = std::move(answer)](SandboxChannel& parent, const std::string& request) {
            try {
              parent.send(kAnswer, answer(request));
            } catch (const std::bad_alloc&) {
              parent.send(kFailed, "there is not enough memory");
            } catch (const std::exception& problem) {
              parent.send(kFailed, problem.what());
            }
          }};
}

void enter_sandbox_if_asked(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[1]) == kOption) run_task(argv[2]);
  can_enter = true;
}

void use_sandbox_program(std::string program) {
  sandbox_program() = std::move(program);
  can_enter = true;
}

void require_isolation() { is_isolation_required = true; }

Sandbox::Sandbox(const SandboxTask& task, const SandboxRules& rules, std::string_view request)
    : Sandbox(task, rules, request, connected_ends()) {}

Sandbox::Sandbox(const SandboxTask& task, const SandboxRules& rules, std::string_view request,
                 std::array<int, 2> ends)
    : most_memory_bytes_(rules.most_memory_bytes), channel_(ends[0]) {
  OpenFile other(ends[1]);
  if (!can_enter) throw std::logic_error("main() must call enter_sandbox_if_asked().");
  check_isolation();
  hide_memory();
  id_ = spawn(task.name(), rules.network, other.descriptor());
  other.close();  // So that the end of the process is the end of the messages.
  channel_.send(kVersion, MULTITETRA_VERSION);
  channel_.send(kRules, packed_values(rules));
  SandboxMessage message;
  try {
    if (!channel_.receive(message, kStartTime)) throw_exit_reason();
    if (message.kind != kIsolated) {
      throw SandboxError("its reader " + printable_line(message.bytes, kMaxReasonBytes));
    }
    channel_.send(kRequest, request);
  } catch (...) {
    stop();
    throw;
  }
}

Sandbox::~Sandbox() { stop(); }

void Sandbox::stop() {
  if (id_ <= 0) return;
  ::kill(id_, SIGKILL);
  ::waitpid(std::exchange(id_, 0), nullptr, 0);
}

void Sandbox::set_memory_limit(std::uint64_t bytes) {
  rlimit limit{};
  if (::prlimit(id_, RLIMIT_AS, nullptr, &limit) != 0) return;
  const std::uint64_t below = most_memory_bytes_ - std::min(bytes, most_memory_bytes_);
  limit.rlim_cur = std::max<rlim_t>(limit.rlim_cur, limit.rlim_max - below);
  (void)::prlimit(id_, RLIMIT_AS, &limit, nullptr);
}

void Sandbox::throw_exit_reason() {
  int status = 0;
  pid_t ended = 0;
  // The process closes its socket shortly before it ends.
  for (int tries = 0; tries < 100 && ended == 0; ++tries) {
    ended = ::waitpid(id_, &status, WNOHANG);
    if (ended == 0) ::usleep(1000);
  }
  if (ended == 0) {
    ::kill(id_, SIGKILL);
    ::waitpid(id_, &status, 0);
    id_ = 0;
    throw SandboxTimeout("its reader timed out");
  }
  id_ = 0;
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
    throw SandboxError("its reader was killed, as by a system without memory left");
  }
  if (WIFSIGNALED(status)) {
    throw SandboxError("its reader crashed (" + std::string(strsignal(WTERMSIG(status))) + ")");
  }
  throw SandboxError("its reader failed");
}

std::string run_in_sandbox(const SandboxTask& task, const SandboxRules& rules,
                           std::string_view request, const AnswerLimits& limits) {
  Sandbox sandbox(task, rules, request);
  SandboxMessage message;
  if (!sandbox.channel().receive(message, limits.time, limits.bytes)) sandbox.throw_exit_reason();
  if (message.kind == kFailed) {
    throw std::runtime_error(printable(message.bytes.substr(0, kMaxReasonBytes)));
  }
  if (message.kind != kAnswer) throw SandboxError("its reader failed");
  return std::move(message.bytes);
}

}  // namespace multitetra

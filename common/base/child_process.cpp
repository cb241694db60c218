#include "common/base/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <utility>

namespace multitetra {
namespace {

constexpr std::size_t kHeadBytes = 9;  // The kind and the length.

std::array<int, 2> connected_ends() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw ChildProcessError(std::string("there is no pair of sockets for it: ") +
                            std::strerror(errno));
  }
  return ends;
}

[[noreturn]] void run_child(const std::function<void(ChildChannel&)>& body, int descriptor,
                            std::uint64_t memory_bytes, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // The parent ended before prctl().
  signal(SIGPIPE, SIG_IGN);
  const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, stream);
  const rlimit no_core = {0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  set_memory_limit(memory_bytes);
  {
    ChildChannel channel(descriptor);
    try {
      body(channel);
    } catch (...) {
      _exit(1);
    }
  }
  _exit(0);
}

}  // namespace

// ---- ChildChannel

ChildChannel::~ChildChannel() { close(descriptor_); }

bool ChildChannel::send(char kind, std::string_view bytes) {
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

bool ChildChannel::read(std::span<std::byte> into, std::chrono::milliseconds timeout) const {
  while (!into.empty()) {
    pollfd waiting = {.fd = descriptor_, .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(timeout.count()));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t got = recv(descriptor_, into.data(), into.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

bool ChildChannel::receive(ChildMessage& message, std::chrono::milliseconds timeout,
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

bool ChildChannel::receive_into(char kind, std::span<std::byte> into, ChildMessage& other,
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

// ---- ChildProcess

ChildProcess::ChildProcess(const std::function<void(ChildChannel&)>& body,
                           std::uint64_t memory_bytes)
    : ChildProcess(body, memory_bytes, connected_ends()) {}

ChildProcess::ChildProcess(const std::function<void(ChildChannel&)>& body,
                           std::uint64_t memory_bytes, std::array<int, 2> ends)
    : channel_(ends[0]) {
  const pid_t parent = getpid();
  id_ = fork();
  if (id_ == 0) {
    close(ends[0]);
    run_child(body, ends[1], memory_bytes, parent);
  }
  const int problem = errno;
  close(ends[1]);
  if (id_ < 0) {
    throw ChildProcessError(std::string("there is no process for it: ") + std::strerror(problem));
  }
}

ChildProcess::~ChildProcess() {
  if (id_ <= 0) return;
  kill(id_, SIGKILL);
  waitpid(id_, nullptr, 0);
}

void ChildProcess::throw_exit_reason() {
  int status = 0;
  pid_t ended = 0;
  // The child's socket closes shortly before the process ends.
  for (int tries = 0; tries < 100 && ended == 0; ++tries) {
    ended = waitpid(id_, &status, WNOHANG);
    if (ended == 0) usleep(1000);
  }
  if (ended == 0) {
    kill(id_, SIGKILL);
    waitpid(id_, &status, 0);
    id_ = 0;
    throw ChildProcessError("it takes too long");
  }
  id_ = 0;
  if (WIFSIGNALED(status)) {
    throw ChildProcessError("its reader crashed (" + std::string(strsignal(WTERMSIG(status))) +
                            ")");
  }
  throw ChildProcessError("its reader gave up");
}

// ---- run_in_child_process

std::string run_in_child_process(const std::function<std::string()>& work,
                                 std::uint64_t memory_bytes, std::chrono::milliseconds time) {
  constexpr char kMade = 'm';
  constexpr char kFailed = 'f';
  ChildProcess child(
      [&](ChildChannel& parent) {
        try {
          parent.send(kMade, work());
        } catch (const std::bad_alloc&) {
          parent.send(kFailed, "there is not enough memory for what it needs");
        } catch (const std::exception& problem) {
          parent.send(kFailed, problem.what());
        }
      },
      memory_bytes);
  ChildMessage message;
  if (!child.channel().receive(message, time, memory_bytes)) child.throw_exit_reason();
  if (message.kind == kFailed) throw std::runtime_error(message.bytes);
  return std::move(message.bytes);
}

// ---- limits

void set_memory_limit(std::uint64_t more_bytes) {
  std::ifstream in("/proc/self/statm");
  std::uint64_t pages = 0;
  in >> pages;
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  const std::uint64_t now = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  limit.rlim_cur = std::min<rlim_t>(now + more_bytes, limit.rlim_max);
  setrlimit(RLIMIT_AS, &limit);
}

}  // namespace multitetra

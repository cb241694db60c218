// Tasks that fail, and tasks that attack from within, in a sandbox.
#include "common/sandbox/sandbox.hpp"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <linux/sched.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <new>
#include <thread>
#include <vector>

#include "common/base/open_file.hpp"
#include "common/sandbox/packed.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using testing::expect_contains;

constexpr std::uint64_t kMemory = std::uint64_t{256} << 20;

const SandboxTask kRepeat =
    answering("test: repeat", [](const std::string& text) { return text + text; });
const SandboxTask kFail = answering("test: fail", [](const std::string& how) -> std::string {
  if (how == "throw") throw std::invalid_argument("in words");
  if (how == "abort") std::abort();
  if (how == "exit") ::_exit(3);
  if (how == "memory") {
    std::vector<char> much(std::size_t{1} << 30, 'x');
    return std::string(much.begin(), much.begin() + 1);
  }
  while (true) std::this_thread::sleep_for(milliseconds(50));
});
const SandboxTask kConverse = {"test: converse", [](SandboxChannel& parent, const std::string&) {
                                 SandboxMessage message;
                                 while (parent.receive(message, milliseconds(5000))) {
                                   parent.send('a', message.bytes + "!");
                                 }
                               }};

std::string failure_of(const std::string& how) {
  try {
    return run_in_sandbox(kFail, {.memory_bytes = kMemory}, how, {.time = milliseconds(1000)});
  } catch (const std::runtime_error& problem) {
    return problem.what();
  }
}

TEST(Sandbox, AnswersRequests) {
  const std::string large(3'000'000, 'x');
  EXPECT_EQ(run_in_sandbox(kRepeat, {}, large), large + large);
  EXPECT_EQ(run_in_sandbox(kRepeat, {}, ""), "");
}

TEST(Sandbox, NamesBothVersionsToAnotherProgram) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  const pid_t id = ::fork();
  if (id == 0) {
    constexpr int kChannel = 3;  // Of a task.
    if (ends[1] == kChannel) ::fcntl(kChannel, F_SETFD, 0);
    if (ends[1] != kChannel) ::dup2(ends[1], kChannel);
    ::execl("/proc/self/exe", "test", "--sandboxed-task", "test: repeat", nullptr);
    ::_exit(1);
  }
  ::close(ends[1]);
  SandboxChannel task(ends[0]);
  ASSERT_TRUE(task.send('v', "0.0.1"));
  SandboxMessage answer;
  ASSERT_TRUE(task.receive(answer, milliseconds(60'000)));
  expect_contains(answer.bytes,
                  "is of version " MULTITETRA_VERSION ", but this program is of version 0.0.1");
  ::waitpid(id, nullptr, 0);
}

TEST(Sandbox, AnswersRepeatedMessages) {
  Sandbox sandbox(kConverse, {}, "");
  SandboxMessage answer;
  for (const std::string word : {"one", "two"}) {
    ASSERT_TRUE(sandbox.channel().send('q', word));
    ASSERT_TRUE(sandbox.channel().receive(answer, milliseconds(5000)));
    EXPECT_EQ(answer.bytes, word + "!");
  }
}

TEST(Sandbox, ContainsCrashesHangsAndMemoryExhaustion) {
  EXPECT_EQ(failure_of("throw"), "in words");
  expect_contains(failure_of("abort"), "its reader crashed (Aborted)");
  expect_contains(failure_of("hang"), "its reader timed out");
  expect_contains(failure_of("exit"), "its reader failed");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  expect_contains(failure_of("memory"), "not enough memory");
#endif
}

// ---- attacks

struct Target {
  fs::path inside;   // A folder that the task may read.
  fs::path outside;  // A file elsewhere.
  pid_t parent = 0;
  std::uint64_t secret = 0;  // An address in the parent.
};
auto fields(Target& target) {
  return std::tie(target.inside, target.outside, target.parent, target.secret);
}

bool opens(const fs::path& path, int flags) {
  return OpenFile(::open(path.c_str(), flags | O_CLOEXEC, 0600)).is_open();
}

bool reads_parent(const Target& target) {
  std::array<char, 8> into{};
  const iovec here{.iov_base = into.data(), .iov_len = into.size()};
  const iovec there{.iov_base = reinterpret_cast<void*>(target.secret),
                    .iov_len = into.size()};  // NOLINT
  return ::process_vm_readv(target.parent, &here, 1, &there, 1, 0) > 0 ||
         ::process_vm_writev(target.parent, &here, 1, &there, 1, 0) > 0;
}

bool raises_its_limit() {
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = limit.rlim_max;
  if (::setrlimit(RLIMIT_AS, &limit) == 0) return true;
  void* const much = ::mmap(nullptr, 2 * kMemory, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return much != MAP_FAILED;
}

bool starts_a_process() {
  const pid_t id = ::fork();
  if (id == 0) ::_exit(0);
  return id > 0;
}

bool starts_a_process_by_clone3() {
  clone_args arguments{};
  const long id = ::syscall(SYS_clone3, &arguments, sizeof(arguments));
  if (id == 0) ::_exit(0);
  return id > 0;
}

bool starts_a_program() {
  std::string name = "/bin/true";
  std::array<char*, 2> words = {name.data(), nullptr};
  ::execve(name.c_str(), words.data(), words.data() + 1);
  return false;  // Else the process does not answer.
}

bool has_other_descriptors() {
  for (int descriptor = 4; descriptor < 1024; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) >= 0) return true;
  }
  return false;
}

bool connects(int family) { return ::socket(family, SOCK_STREAM, 0) >= 0; }

bool runs_written_code() {
  void* const page =
      ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return page == MAP_FAILED || ::mprotect(page, 4096, PROT_READ | PROT_EXEC) == 0;
}

// Tries everything, and returns what has succeeded.
std::string attack(const std::string& request) {
  Target target;
  if (!unpack_all(request, target)) return "request";
  const std::string process = "/proc/" + std::to_string(target.parent);
  const fs::path file = target.inside / "file";
  const std::vector<std::pair<const char*, std::function<bool()>>> tries = {
      {"file outside", [&] { return opens(target.outside, O_RDONLY); }},
      {"file by ..", [&] { return opens(target.inside / ".." / ".." / target.outside, O_RDONLY); }},
      {"folder outside", [&] { return opens("/", O_RDONLY | O_DIRECTORY); }},
      {"writing", [&] { return opens(file, O_WRONLY); }},
      {"appending", [&] { return opens(file, O_RDWR | O_APPEND); }},
      {"creating", [&] { return opens(target.inside / "new", O_RDONLY | O_CREAT); }},
      {"temporary file", [&] { return opens(target.inside, O_WRONLY | O_TMPFILE); }},
      {"truncating", [&] { return ::truncate(file.c_str(), 0) == 0; }},
      {"removing", [&] { return ::unlink(file.c_str()) == 0; }},
      {"renaming", [&] { return ::rename(file.c_str(), (file.string() + "2").c_str()) == 0; }},
      {"permissions", [&] { return ::chmod(file.c_str(), 0777) == 0; }},
      {"links", [&] { return ::symlink("/etc", (target.inside / "link").c_str()) == 0; }},
      {"IPv4", [] { return connects(AF_INET); }},
      {"IPv6", [] { return connects(AF_INET6); }},
      {"Unix socket", [] { return connects(AF_UNIX); }},
      {"netlink", [] { return connects(AF_NETLINK); }},
      {"socket pair",
       [] {
         int ends[2];
         return ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0;
       }},  // NOLINT
      {"process", starts_a_process},
      {"process by clone3", starts_a_process_by_clone3},
      {"program", starts_a_program},
      {"tracing", [&] { return ::ptrace(PTRACE_ATTACH, target.parent, nullptr, nullptr) == 0; }},
      {"memory of the parent", [&] { return reads_parent(target); }},
      {"memory by file", [&] { return opens(process + "/mem", O_RDONLY); }},
      {"environment of the parent", [&] { return opens(process + "/environ", O_RDONLY); }},
      {"signals", [&] { return ::kill(target.parent, 0) == 0; }},
      {"more memory", raises_its_limit},
      {"code", runs_written_code},
      {"namespaces", [] { return ::unshare(CLONE_NEWUSER) == 0; }},
      {"BPF", [] { return ::syscall(SYS_bpf, 0, nullptr, 0) >= 0 || errno != EPERM; }},
      {"environment", [] { return environ != nullptr && *environ != nullptr; }},
      {"descriptors", has_other_descriptors},
  };
  std::string succeeded;
  for (const auto& [name, succeeds] : tries) {
    if (succeeds()) succeeded += std::string(succeeded.empty() ? "" : ", ") + name;
  }
  return succeeded;
}
const SandboxTask kAttack = answering("test: attack", attack);

const SandboxTask kRead = answering("test: read", [](const std::string& file) {
  return OpenFile(fs::path(file)).content(100).value_or("unreadable");
});
const SandboxTask kThreads = answering("test: threads", [](const std::string&) {
  int sum = 0;
  std::thread([&] { sum = 3; }).join();
  return std::to_string(sum);
});
const SandboxTask kConnect = answering("test: connect", [](const std::string& file) {
  std::string done;
  if (connects(AF_INET)) done += "IPv4 ";
  if (connects(AF_UNIX)) done += "Unix ";
  if (opens(file, O_RDONLY)) done += "file ";
  if (std::getenv("AWS_SECRET_ACCESS_KEY") != nullptr) done += "key ";
  if (std::getenv("MULTITETRA_TEST_SECRET") != nullptr) done += "secret ";
  return done;
});

const SandboxTask kTake = {"test: take", [](SandboxChannel& parent, const std::string&) {
                             SandboxMessage message;
                             while (parent.receive(message, milliseconds(5000))) {
                               // Volatile, or compilers leave it out.
                               char* volatile const much = new (std::nothrow) char[kMemory];
                               parent.send('a', much == nullptr ? "refused" : "taken");
                               delete[] much;
                             }
                           }};

class SandboxIsolation : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_of_this_kernel().is_complete()) {
      GTEST_SKIP() << "NOT TESTED: " << text_of(isolation_of_this_kernel());
    }
    inside_.file("data/file", "inside");
    outside_.file("file", "outside");
  }

  TemporaryFolder inside_;
  TemporaryFolder outside_;
};

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(SandboxIsolation, RefusesEverythingButReadingWhatIsListed) {
  const std::array<char, 8> secret = {'s', 'e', 'c', 'r', 'e', 't'};
  const int open_in_parent = ::open("/etc/passwd", O_RDONLY);  // NOLINT: to be inherited.
  const Target target{.inside = inside_.path() / "data",
                      .outside = outside_.path() / "file",
                      .parent = ::getpid(),
                      .secret = reinterpret_cast<std::uint64_t>(secret.data())};
  EXPECT_EQ(
      run_in_sandbox(kAttack, {.readable = {inside_.path() / "data"}, .memory_bytes = kMemory},
                     packed_values(target)),
      "");
  ::close(open_in_parent);
  EXPECT_EQ(bytes_of_file(inside_.path() / "data" / "file"), "inside");
  EXPECT_EQ(entries_of(inside_.path() / "data"), 1U);
}
#endif

TEST_F(SandboxIsolation, AllowsReadingWhatIsListed) {
  const std::string file = (inside_.path() / "data" / "file").string();
  for (const fs::path& place : {inside_.path(), inside_.path() / "data", fs::path(file)}) {
    EXPECT_EQ(run_in_sandbox(kRead, {.readable = {place, "/not/there"}}, file), "inside") << place;
  }
  EXPECT_EQ(run_in_sandbox(kRead, {}, file), "unreadable");
  EXPECT_EQ(run_in_sandbox(kThreads, {}, ""), "3");
}

TEST_F(SandboxIsolation, AllowsTheNetworkOrFiles) {
  ::setenv("AWS_SECRET_ACCESS_KEY", "key", 1);
  ::setenv("MULTITETRA_TEST_SECRET", "secret", 1);
  const std::string file = (inside_.path() / "data" / "file").string();
  EXPECT_EQ(run_in_sandbox(kConnect, {.network = true}, file), "IPv4 key ");
  EXPECT_EQ(run_in_sandbox(kConnect, {.readable = {file}}, file), "file ");
  ::unsetenv("AWS_SECRET_ACCESS_KEY");
  ::unsetenv("MULTITETRA_TEST_SECRET");
}

TEST_F(SandboxIsolation, RaisesTheLimitOfMemoryOnRequest) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const auto take = [](Sandbox& sandbox) {
    SandboxMessage message;
    sandbox.channel().send('q', {});
    EXPECT_TRUE(sandbox.channel().receive(message, milliseconds(5000)));
    return message.bytes;
  };
  Sandbox sandbox(kTake, {.memory_bytes = kMemory / 2, .most_memory_bytes = 4 * kMemory}, "");
  EXPECT_EQ(take(sandbox), "refused");
  sandbox.set_memory_limit(2 * kMemory);
  EXPECT_EQ(take(sandbox), "taken");
#endif
}

}  // namespace
}  // namespace multitetra

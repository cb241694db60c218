#include "common/sandbox/isolation.hpp"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "common/base/open_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to(const char* what, int error) {
  throw std::runtime_error(std::string("cannot ") + what + ": " +
                           std::generic_category().message(error));
}

// ---- Landlock, as the kernel defines it: headers of distributions are older than kernels.

constexpr long kCreateRuleset = 444;
constexpr long kAddRule = 445;
constexpr long kRestrictSelf = 446;
constexpr unsigned kAskVersion = 1;
constexpr int kRulePathBeneath = 1;
constexpr std::uint64_t kReadFile = 1U << 2;
constexpr std::uint64_t kReadFolder = 1U << 3;
constexpr std::uint64_t kConnect = 1U << 1;

struct Ruleset {
  std::uint64_t files = 0;
  std::uint64_t network = 0;
  std::uint64_t scopes = 0;
};
struct [[gnu::packed]] PathBeneath {
  std::uint64_t allowed;
  std::int32_t folder;
};

int landlock_version() {
  const long version = ::syscall(kCreateRuleset, nullptr, 0, kAskVersion);
  return version < 0 ? 0 : static_cast<int>(version);
}

// Returns all rights over files, the network and other processes that this version knows.
Ruleset everything(int version) {
  constexpr std::array<int, 7> kRights = {0, 13, 14, 15, 15, 16, 16};  // By version.
  const int rights = kRights[static_cast<std::size_t>(std::min(version, 6))];
  return {.files = (std::uint64_t{1} << rights) - 1,
          .network = version >= 4 ? 3U : 0U,  // To listen and to connect, by TCP.
          .scopes = version >= 6 ? 3U : 0U};  // Abstract sockets and signals.
}

// The files of name resolution and TLS.
std::vector<fs::path> network_files() {
  std::vector<fs::path> files = {"/etc/resolv.conf",
                                 "/etc/hosts",
                                 "/etc/host.conf",
                                 "/etc/nsswitch.conf",
                                 "/etc/gai.conf",
                                 "/etc/services",
                                 "/etc/ssl",
                                 "/etc/pki",
                                 "/etc/ca-certificates",
                                 "/usr/lib/ssl",
                                 "/usr/share/ca-certificates",
                                 "/usr/local/share/ca-certificates",
                                 "/run/systemd/resolve"};
  for (const char* const name : {"SSL_CERT_FILE", "SSL_CERT_DIR", "CURL_CA_BUNDLE"}) {
    if (const char* const value = std::getenv(name)) files.emplace_back(value);
  }
  return files;
}

void allow_reading(int ruleset, const fs::path& path) {
  const OpenFile opened(::open(path.c_str(), O_PATH | O_CLOEXEC));
  struct stat status {};
  if (!opened.is_open() || ::fstat(opened.descriptor(), &status) != 0) return;
  const PathBeneath rule = {
      .allowed = S_ISDIR(status.st_mode) ? kReadFile | kReadFolder : kReadFile,
      .folder = opened.descriptor()};
  if (::syscall(kAddRule, ruleset, kRulePathBeneath, &rule, 0) != 0) {
    fail_to("allow reading", errno);
  }
}

void restrict_files(const SandboxRules& rules) {
  const int version = landlock_version();
  if (version == 0) return;
  Ruleset handled = everything(version);
  if (rules.network) handled.network &= ~kConnect;
  const OpenFile ruleset(static_cast<int>(::syscall(kCreateRuleset, &handled, sizeof(handled), 0)));
  if (!ruleset.is_open()) fail_to("create rules for files", errno);
  for (const fs::path& path : rules.readable) allow_reading(ruleset.descriptor(), path);
  if (rules.network) {
    for (const fs::path& path : network_files()) allow_reading(ruleset.descriptor(), path);
  }
  if (::syscall(kRestrictSelf, ruleset.descriptor(), 0) != 0) fail_to("restrict files", errno);
}

// ---- seccomp

// What the standard libraries need to compute, to read files and to use open sockets.
constexpr std::array kAllowed = {
    "access",
    "brk",
    "clock_getres",
    "clock_gettime",
    "clock_nanosleep",
    "close",
    "dup",
    "exit",
    "exit_group",
    "faccessat",
    "faccessat2",
    "fadvise64",
    "fcntl",
    "flock",
    "fstat",
    "fstat64",
    "fstatfs",
    "futex",
    "getcwd",
    "getdents",
    "getdents64",
    "getegid",
    "geteuid",
    "getgid",
    "getpid",
    "getppid",
    "getrandom",
    "getrlimit",
    "getrusage",
    "gettid",
    "gettimeofday",
    "getuid",
    "lseek",
    "_llseek",
    "lstat",
    "lstat64",
    "madvise",
    "membarrier",
    "mincore",
    "mremap",
    "munmap",
    "nanosleep",
    "newfstatat",
    "pipe2",
    "poll",
    "ppoll",
    "pread64",
    "preadv",
    "pselect6",
    "read",
    "readahead",
    "readlink",
    "readlinkat",
    "readv",
    "recvfrom",
    "recvmsg",
    "restart_syscall",
    "rseq",
    "rt_sigaction",
    "rt_sigprocmask",
    "rt_sigreturn",
    "sched_getaffinity",
    "sched_yield",
    "select",
    "sendto",
    "set_robust_list",
    "set_tid_address",
    "sigaltstack",
    "stat",
    "stat64",
    "statfs",
    "statx",
    "sysinfo",
    "time",
    "uname",
    "write",
    "writev",
};
constexpr std::array kAllowedForNetwork = {
    "connect",  "epoll_create1", "epoll_ctl",   "epoll_pwait", "epoll_wait",
    "eventfd2", "getpeername",   "getsockname", "getsockopt",  "ioctl",
    "sendmmsg", "sendmsg",       "setsockopt",  "shutdown",    "socketpair",
};

using Filter = std::unique_ptr<void, decltype(&seccomp_release)>;

// Allows a call, under conditions on its arguments. Ignores calls that this machine does not have.
template <typename... Condition>
void allow(const Filter& filter, const char* name, const Condition&... conditions) {
  const int call = seccomp_syscall_resolve_name(name);
  if (call < 0) return;
  const int failed =
      seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, sizeof...(conditions), conditions...);
  if (failed != 0) fail_to("restrict system calls", -failed);
}

scmp_arg_cmp equal(unsigned argument, std::uint64_t mask, std::uint64_t value) {
  return {.arg = argument, .op = SCMP_CMP_MASKED_EQ, .datum_a = mask, .datum_b = value};
}

void restrict_calls(const SandboxRules& rules) {
  const Filter filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), &seccomp_release);
  if (!filter) throw std::runtime_error("cannot create rules for system calls");
  for (const char* const name : kAllowed) allow(filter, name);
  constexpr std::uint64_t kAll = ~std::uint64_t{0};
  // Opened for reading only.
  constexpr std::uint64_t kWrites = O_ACCMODE | O_CREAT | O_TRUNC | (O_TMPFILE & ~O_DIRECTORY);
  allow(filter, "open", equal(1, kWrites, O_RDONLY));
  allow(filter, "openat", equal(2, kWrites, O_RDONLY));
  // No executable memory.
  for (const char* const name : {"mmap", "mmap2", "mprotect"}) {
    allow(filter, name, equal(2, PROT_EXEC, 0));
  }
  // Threads, no processes. clone3() has its flags in memory, and the C library replaces it if there
  // is none.
  allow(filter, "clone", equal(0, CLONE_THREAD | CLONE_VM, CLONE_THREAD | CLONE_VM));
  (void)seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  // Signals to itself: abort().
  allow(filter, "tgkill", equal(0, kAll, static_cast<std::uint64_t>(::getpid())));
  allow(filter, "prlimit64", equal(2, kAll, 0));  // Reads limits.
  allow(filter, "prctl", equal(0, kAll, PR_SET_NAME));
  if (rules.network) {
    for (const char* const name : kAllowedForNetwork) allow(filter, name);
    for (const int family : {AF_INET, AF_INET6, AF_NETLINK}) {
      allow(filter, "socket", equal(0, kAll, static_cast<std::uint64_t>(family)));
    }
    allow(filter, "bind");  // To a local port: for netlink.
  }
  if (const int failed = seccomp_load(filter.get()); failed != 0) {
    fail_to("restrict system calls", -failed);
  }
}

// ---- limits

std::uint64_t address_space() {
  std::ifstream in("/proc/self/statm");
  std::uint64_t pages = 0;
  in >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit_resources(const SandboxRules& rules) {
  const rlimit none = {0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const std::uint64_t now = address_space();
  rlimit memory{};
  ::getrlimit(RLIMIT_AS, &memory);
  memory.rlim_max = std::min<rlim_t>(now + rules.most_memory_bytes, memory.rlim_max);
  memory.rlim_cur = std::min<rlim_t>(now + rules.memory_bytes, memory.rlim_max);
  if (::setrlimit(RLIMIT_AS, &memory) != 0) fail_to("limit the memory", errno);
}

bool has_seccomp() { return ::prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0; }

}  // namespace

Isolation isolation_of_this_kernel() {
  return {.landlock = landlock_version(), .seccomp = has_seccomp()};
}

std::string text_of(const Isolation& isolation) {
  return (isolation.landlock > 0 ? "landlock " + std::to_string(isolation.landlock)
                                 : std::string("no landlock")) +
         (isolation.seccomp ? ", seccomp" : ", no seccomp");
}

void isolate(const SandboxRules& rules) {
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) fail_to("give up privileges", errno);
  limit_resources(rules);
  restrict_files(rules);
  if (has_seccomp()) restrict_calls(rules);
}

}  // namespace multitetra

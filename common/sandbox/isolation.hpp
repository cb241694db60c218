// What a sandboxed process may do, as far as the kernel can enforce it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

namespace multitetra {

// The kernel's means.
struct Isolation {
  int landlock = 0;  // The version of Landlock's interface; 0 without it.
  bool seccomp = false;

  [[nodiscard]] bool is_complete() const { return landlock > 0 && seccomp; }
};
[[nodiscard]] Isolation isolation_of_this_kernel();
// Returns "landlock 6, seccomp", or names what is missing: "no landlock, seccomp".
[[nodiscard]] std::string text_of(const Isolation& isolation);

// Everything that is not listed is refused: other files, writing, programs, processes, sockets,
// signals and memory of other processes, executable memory.
struct SandboxRules {
  // Files, and folders with all that is in them, to read. Missing ones are ignored.
  std::vector<std::filesystem::path> readable = {};
  // Connections to other hosts, with the files that name resolution and TLS need.
  bool network = false;
  // The limit of memory beyond that at the start, and the one that the parent may set later; in
  // bytes of address space.
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  std::uint64_t most_memory_bytes = memory_bytes;
};
inline auto fields(SandboxRules& rules) {
  return std::tie(rules.readable, rules.network, rules.memory_bytes, rules.most_memory_bytes);
}

// Restricts this process, for ever. Requires a single thread. Throws std::runtime_error if the
// kernel has the means and refuses them.
void isolate(const SandboxRules& rules);

}  // namespace multitetra

#include "server/dataset/detail/mapped_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <system_error>

namespace multitetra {

// The signal handler searches the guards and may not take a lock, so guards are never freed but
// reused. A guard with end 0 is free.
struct MappedFile::Guard {
  std::atomic<std::uintptr_t> begin = 0;
  std::atomic<std::uintptr_t> end = 0;
  std::atomic<bool> has_lost = false;  // A page could not be read.
  Guard* next = nullptr;

  [[nodiscard]] static Guard* of(std::span<const std::byte> bytes);
  static void replace_lost_pages(int signal, siginfo_t* info, void* context);

  static inline std::atomic<Guard*> first = nullptr;
  static inline std::mutex mutex;  // Held while a guard is created or reused.
  static inline struct sigaction other_handler = {};
};

static_assert(std::atomic<std::uintptr_t>::is_always_lock_free);

// Replaces everything from the lost page to the end of the mapping: replacing single pages could
// exceed the number of mappings that a process may have.
void MappedFile::Guard::replace_lost_pages(int signal, siginfo_t* info, void*) {
  const int saved_errno = errno;
  const auto page_size = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto at = reinterpret_cast<std::uintptr_t>(info->si_addr);
  for (Guard* guard = first.load(); guard != nullptr; guard = guard->next) {
    const std::uintptr_t end = guard->end.load();
    if (at < guard->begin.load() || at >= end) continue;
    const std::uintptr_t from = at - at % page_size;
    guard->has_lost = true;
    void* const zeros = ::mmap(reinterpret_cast<void*>(from), end - from, PROT_READ,
                               MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0);
    errno = saved_errno;
    if (zeros != MAP_FAILED) return;
  }
  ::sigaction(signal, &other_handler, nullptr);  // Receives the signal next.
  errno = saved_errno;
}

MappedFile::Guard* MappedFile::Guard::of(std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex);
  if (first.load() == nullptr) {
    struct sigaction handler = {};
    handler.sa_sigaction = replace_lost_pages;
    handler.sa_flags = SA_SIGINFO;
    ::sigemptyset(&handler.sa_mask);
    ::sigaction(SIGBUS, &handler, &other_handler);
  }
  Guard* guard = first.load();
  while (guard != nullptr && guard->end.load() != 0) guard = guard->next;
  if (guard == nullptr) {
    guard = new Guard;
    guard->next = first.load();
    first = guard;
  }
  guard->has_lost = false;
  guard->begin = reinterpret_cast<std::uintptr_t>(bytes.data());
  guard->end = reinterpret_cast<std::uintptr_t>(bytes.data()) + bytes.size();
  return guard;
}

MappedFile::MappedFile(const std::filesystem::path& path) : file_(path), opened_(state()) {
  if (file_.size_ == 0) return;  // Empty files cannot be mapped.
  void* const memory =
      ::mmap(nullptr, file_.size_, PROT_READ, MAP_SHARED, file_.opened_.descriptor(), /*offset=*/0);
  if (memory == MAP_FAILED) {
    const int reason = errno;
    throw DatasetFileError(
        path, "it cannot be mapped into memory: " + std::generic_category().message(reason) + ".");
  }
  bytes_ = {static_cast<const std::byte*>(memory), file_.size_};
  guard_ = Guard::of(bytes_);
}

MappedFile::~MappedFile() {
  if (guard_ != nullptr) guard_->end = 0;
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

MappedFile::State MappedFile::state() const {
  struct stat status = {};
  if (::fstat(file_.opened_.descriptor(), &status) != 0) return {};
  return {.size = status.st_size,
          .seconds = status.st_mtim.tv_sec,
          .nanoseconds = status.st_mtim.tv_nsec};
}

void MappedFile::check() const {
  if (guard_ != nullptr && guard_->has_lost) {
    throw DatasetFileError(file_.file_,
                           "a part of it is missing, or the disk cannot read it. Restore the file; "
                           "a server then needs SIGHUP or a restart.");
  }
  if (state() == opened_) return;
  throw DatasetFileError(file_.file_,
                         "it was overwritten while it was open. Replace it with a good file, by "
                         "renaming; a server then needs SIGHUP or a restart.");
}

}  // namespace multitetra

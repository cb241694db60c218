#include "server/dataset/objects/object_disk_cache.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "common/base/atomic_file.hpp"
#include "server/store/object_store.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMeasuredAfter = 16;  // Measured anew after this part of the limit came.

// One process at a time; others do without.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : descriptor_(::open((folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
    is_held_ = descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
  }
  ~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  [[nodiscard]] bool is_held() const { return is_held_; }

 private:
  int descriptor_;
  bool is_held_ = false;
};

struct CachedObject {
  fs::file_time_type used;
  std::uint64_t bytes = 0;
  fs::path path;
};

std::vector<CachedObject> objects_in(const fs::path& folder) {
  std::vector<CachedObject> found;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder / "objects", error), end; !error && at != end;
       at.increment(error)) {
    std::error_code gone;  // Somebody else may remove it meanwhile.
    if (!at->is_regular_file(gone)) continue;
    const CachedObject object{.used = at->last_write_time(gone),
                              .bytes = gone ? 0 : at->file_size(gone),
                              .path = at->path()};
    if (!gone) found.push_back(object);
  }
  return found;
}

}  // namespace

ObjectDiskCache::ObjectDiskCache(fs::path folder, std::uint64_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes) {
  if (fs::create_directories(folder_)) fs::permissions(folder_, fs::perms::owner_all);
  make_room();
}

std::optional<std::vector<std::byte>> ObjectDiskCache::find(const ObjectName& name) const {
  try {
    auto bytes = folder_store(folder_)->get(name.key(), name.size);
    // Its time of writing says when it was used last.
    if (bytes) ::utimensat(AT_FDCWD, (folder_ / name.key()).c_str(), nullptr, 0);
    return bytes;
  } catch (const StoreError&) {
    return std::nullopt;
  }
}

void ObjectDiskCache::put(const ObjectName& name, std::span<const std::byte> bytes) {
  try {
    const fs::path path = folder_ / name.key();
    fs::create_directories(path.parent_path());
    AtomicFile file(path);
    file.write_at(0, bytes);
    file.commit(Durability::kProcessEnd);
  } catch (const std::system_error&) {
    return;  // A full disk is no trouble of the one who asks.
  }
  const std::lock_guard lock(mutex_);
  put_since_ += bytes.size();
  if (put_since_ < most_bytes_ / kMeasuredAfter) return;
  put_since_ = 0;
  make_room();
}

void ObjectDiskCache::remove(const ObjectName& name) {
  std::error_code ignored;
  fs::remove(folder_ / name.key(), ignored);
}

void ObjectDiskCache::make_room() {
  const FolderLock lock(folder_);
  if (!lock.is_held()) return;
  std::vector<CachedObject> objects = objects_in(folder_);
  std::uint64_t bytes = 0;
  for (const CachedObject& object : objects) bytes += object.bytes;
  // So much less that it is worth the look.
  const std::uint64_t allowed = most_bytes_ - most_bytes_ / kMeasuredAfter;
  if (bytes <= allowed) return;
  std::sort(objects.begin(), objects.end(),
            [](const CachedObject& a, const CachedObject& b) { return a.used < b.used; });
  for (const CachedObject& object : objects) {
    if (bytes <= allowed) break;
    std::error_code ignored;
    fs::remove(object.path, ignored);
    bytes -= object.bytes;
  }
}

}  // namespace multitetra

#include "server/store/object_store.hpp"

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "common/base/open_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// An open regular file.
class ObjectFile {
 public:
  explicit ObjectFile(fs::path path) : path_(std::move(path)), file_(path_) {
    if (!file_.is_open()) fail_with_reason();
    const auto size = file_.regular_size();
    if (!size) fail("it is not a regular file");
    size_ = *size;
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) const {
    const auto count = file_.read_some(offset, into);
    if (!count) fail_with_reason();
    if (*count < into.size()) fail("it was truncated while it was read");
  }
  [[noreturn]] void fail(const std::string& problem) const {
    throw StoreError(path_.string(), problem, "Check the file and its disk");
  }

 private:
  [[noreturn]] void fail_with_reason() const {
    const int reason = errno;
    fail(std::generic_category().message(reason));
  }

  fs::path path_;
  OpenFile file_;
  std::uint64_t size_ = 0;
};

class FolderStore : public ObjectStore {
 public:
  FolderStore(fs::path folder, bool allow_external_files)
      : folder_(std::move(folder)),
        allow_external_files_(allow_external_files),
        real_folder_(fs::weakly_canonical(folder_)) {}

  std::optional<std::vector<std::byte>> get(const std::string& key,
                                            std::uint64_t max_bytes) override {
    const std::optional<fs::path> path = path_of(key);
    if (!path) return std::nullopt;
    const ObjectFile file(*path);
    if (file.size() > max_bytes) {
      file.fail("it has " + std::to_string(file.size()) + " bytes; the limit is " +
                std::to_string(max_bytes));
    }
    std::vector<std::byte> bytes(file.size());
    file.read(0, bytes);
    return bytes;
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    const std::optional<fs::path> path = path_of(key);
    if (!path) return std::nullopt;
    const ObjectFile file(*path);
    length = std::min(length, file.size());
    if (offset == kFromEnd) offset = file.size() - length;
    length = offset > file.size() ? 0 : std::min(length, file.size() - offset);
    std::vector<std::byte> bytes(length);
    file.read(offset, bytes);
    return bytes;
  }

  [[nodiscard]] std::vector<std::string> names(const std::string& key) override {
    constexpr std::size_t kMaxNames = 10'000;
    std::vector<std::string> names;
    const std::optional<fs::path> path = path_of(key);
    std::error_code error;
    if (!path) return names;
    for (fs::directory_iterator entry(*path, error), end;
         !error && entry != end && names.size() < kMaxNames; entry.increment(error)) {
      names.push_back(entry->path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  [[nodiscard]] fs::path place(const std::string& key) const override { return folder_ / key; }
  [[nodiscard]] std::size_t parallel_requests() const override {
    return std::clamp(std::thread::hardware_concurrency(), 1u, 32u);
  }

 private:
  // Keys come from metadata: keeps them below the folder. Returns nullopt if there is no file.
  [[nodiscard]] std::optional<fs::path> path_of(const std::string& key) const {
    const fs::path inside(key);
    const bool names_out =
        inside.is_absolute() || std::find(inside.begin(), inside.end(), "..") != inside.end();
    if (names_out && !allow_external_files_) fail_leading_out(key);
    std::error_code error;
    if (!fs::exists(folder_ / inside, error)) return std::nullopt;
    if (allow_external_files_) return folder_ / inside;
    const fs::path real = fs::canonical(folder_ / inside, error);
    const fs::path below = real.lexically_relative(real_folder_);
    if (error || below.empty() || *below.begin() == "..") fail_leading_out(key);
    return folder_ / inside;
  }

  [[noreturn]] void fail_leading_out(const std::string& key) const {
    throw StoreError(folder_.string(), "it refers to '" + key + "', which is outside the folder",
                     "Put the file into the folder, or allow it with --follow if you trust it");
  }

  fs::path folder_;
  bool allow_external_files_;
  fs::path real_folder_;
};

}  // namespace

std::unique_ptr<ObjectStore> folder_store(fs::path folder, bool allow_external_files) {
  return std::make_unique<FolderStore>(std::move(folder), allow_external_files);
}

std::optional<std::string> text_of(ObjectStore& store, const std::string& key) {
  constexpr std::uint64_t kMaxTextBytes = std::uint64_t{1} << 24;
  const auto bytes = store.get(key, kMaxTextBytes);
  if (!bytes) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

}  // namespace multitetra

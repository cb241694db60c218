#include "server/dataset/formats/object_store.hpp"

#include <algorithm>
#include <span>
#include <thread>
#include <utility>

#include "server/dataset/formats/input_file.hpp"
#include "server/dataset/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

class FolderStore : public ObjectStore {
 public:
  explicit FolderStore(fs::path folder) : folder_(std::move(folder)) {}

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    const std::optional<InputFile> file = opened(key);
    if (!file) return std::nullopt;
    if (file->size() > most) {
      fail_reading(
          file->path(),
          "it has " + std::to_string(file->size()) + " bytes and may have " + std::to_string(most),
          "Check that it belongs to this array");
    }
    std::vector<std::byte> bytes(file->size());
    file->read(0, bytes);
    return bytes;
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    const std::optional<InputFile> file = opened(key);
    if (!file) return std::nullopt;
    length = std::min(length, file->size());
    if (offset == kFromEnd) offset = file->size() - length;
    length = offset > file->size() ? 0 : std::min(length, file->size() - offset);
    std::vector<std::byte> bytes(length);
    file->read(offset, bytes);
    return bytes;
  }

  [[nodiscard]] fs::path place(const std::string& key) const override { return folder_ / key; }
  [[nodiscard]] std::size_t parallel_requests() const override {
    return std::clamp(std::thread::hardware_concurrency(), 1u, 32u);
  }

 private:
  // Keys come from metadata: they stay below the folder.
  [[nodiscard]] std::optional<InputFile> opened(const std::string& key) const {
    const fs::path inside(key);
    if (inside.is_absolute() || std::find(inside.begin(), inside.end(), "..") != inside.end()) {
      fail_reading(folder_, "it names '" + key + "', which leads out of the folder",
                   "Correct its metadata");
    }
    std::error_code error;
    if (!fs::exists(folder_ / inside, error)) return std::nullopt;
    return InputFile(folder_ / inside);
  }

  fs::path folder_;
};

}  // namespace

std::unique_ptr<ObjectStore> folder_store(fs::path folder) {
  return std::make_unique<FolderStore>(std::move(folder));
}

std::optional<std::string> text_of(ObjectStore& store, const std::string& key) {
  constexpr std::uint64_t kMostTextBytes = std::uint64_t{1} << 24;
  const auto bytes = store.get(key, kMostTextBytes);
  if (!bytes) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

}  // namespace multitetra

#include "server/volume/formats/detail/zip_store.hpp"

#include <zip.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

using OpenEntry = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

class ZipStore : public ObjectStore {
 public:
  explicit ZipStore(const fs::path& file) : file_(file), archive_(nullptr, &zip_discard) {
    const InputFile input(file);  // Reports errors of the file itself.
    archive_.reset(zip_open(file.c_str(), ZIP_RDONLY, nullptr));
    if (!archive_) fail("", "it is not a complete zip archive");
    const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(std::max<zip_int64_t>(count, 0)); ++i) {
      const char* const name = zip_get_name(archive_.get(), i, ZIP_FL_ENC_RAW);
      if (name != nullptr && !std::string_view(name).ends_with('/')) entries_[name] = i;
    }
    find_prefix();
  }

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    const auto entry = entries_.find(prefix_ + key);
    if (entry == entries_.end()) return std::nullopt;
    const std::lock_guard lock(mutex_);
    const std::uint64_t size = size_of(key, entry->second);
    if (size > most) {
      fail(key, "it has " + std::to_string(size) + " bytes; the limit is " + std::to_string(most));
    }
    return part(key, opened(key, entry->second), size);
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    const auto entry = entries_.find(prefix_ + key);
    if (entry == entries_.end()) return std::nullopt;
    const std::lock_guard lock(mutex_);
    const std::uint64_t size = size_of(key, entry->second);
    length = std::min(length, size);
    if (offset == kFromEnd) offset = size - length;
    length = offset > size ? 0 : std::min(length, size - offset);
    OpenEntry stream = opened(key, entry->second);
    if (zip_fseek(stream.get(), static_cast<zip_int64_t>(std::min(offset, size)), SEEK_SET) == 0) {
      return part(key, std::move(stream), length);
    }
    constexpr std::uint64_t kMaxUnpackedBytes = std::uint64_t{1} << 28;
    if (size > kMaxUnpackedBytes) fail(key, "it is a large deflated shard, which is not supported");
    const std::vector<std::byte> all = part(key, opened(key, entry->second), size);
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(std::min(offset, size));
    return std::vector<std::byte>(begin, begin + static_cast<std::ptrdiff_t>(length));
  }

  [[nodiscard]] std::vector<std::string> names(const std::string& key) override {
    const std::string prefix = prefix_ + key;
    std::set<std::string> names;
    for (auto entry = entries_.lower_bound(prefix);
         entry != entries_.end() && entry->first.starts_with(prefix); ++entry) {
      const std::string rest = entry->first.substr(prefix.size());
      names.insert(rest.substr(0, rest.find('/')));
    }
    return {names.begin(), names.end()};
  }

  [[nodiscard]] fs::path place(const std::string& key) const override { return file_ / key; }
  [[nodiscard]] std::size_t parallel_requests() const override { return 4; }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const {
    fail_reading(place(key), problem, "Compare the archive with another copy, or pack it again");
  }

  [[nodiscard]] OpenEntry opened(const std::string& key, zip_uint64_t entry) const {
    OpenEntry stream(zip_fopen_index(archive_.get(), entry, 0), &zip_fclose);
    if (stream) return stream;
    fail(key, std::string("it cannot be read: ") + zip_strerror(archive_.get()));
  }

  [[nodiscard]] std::uint64_t size_of(const std::string& key, zip_uint64_t entry) const {
    zip_stat_t stat{};
    constexpr zip_uint64_t kSizes = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
    const bool is_known =
        zip_stat_index(archive_.get(), entry, 0, &stat) == 0 && (stat.valid & kSizes) == kSizes;
    // Deflate compresses at most about a thousandfold.
    if (!is_known || stat.size / 1100 > stat.comp_size) {
      fail(key, "its sizes in the archive are invalid");
    }
    return stat.size;
  }

  // Reads `length` bytes; at the end of an entry that is read whole, checks its checksum.
  [[nodiscard]] std::vector<std::byte> part(const std::string& key, OpenEntry stream,
                                            std::uint64_t length) const {
    std::vector<std::byte> bytes(length);
    std::uint64_t done = 0;
    zip_int64_t count = 1;
    while (done < length && count > 0) {
      count = zip_fread(stream.get(), bytes.data() + done, length - done);
      done += static_cast<std::uint64_t>(std::max<zip_int64_t>(count, 0));
    }
    std::byte none{};
    if (done == length) count = zip_fread(stream.get(), &none, 1);
    const zip_error_t* const error = zip_file_get_error(stream.get());
    if (count < 0 && zip_error_code_zip(error) == ZIP_ER_CRC) {
      fail(key, "its checksum (CRC-32) does not match");
    }
    if (done < length || count < 0) fail(key, "its bytes in the archive are damaged");
    return bytes;
  }

  void find_prefix() {
    std::size_t least = ~std::size_t{0};
    for (const auto& [name, entry] : entries_) {
      const std::size_t slash = name.rfind('/');
      const std::string last = slash == std::string::npos ? name : name.substr(slash + 1);
      if (last != "zarr.json" && last != ".zattrs" && last != ".zgroup" && last != ".zarray" &&
          last != "attributes.json")
        continue;
      const auto depth = static_cast<std::size_t>(std::count(name.begin(), name.end(), '/'));
      if (depth >= least) continue;
      least = depth;
      prefix_ = slash == std::string::npos ? std::string() : name.substr(0, slash + 1);
    }
  }

  fs::path file_;
  std::mutex mutex_;  // Guards archive_.
  std::unique_ptr<zip_t, decltype(&zip_discard)> archive_;
  std::map<std::string, zip_uint64_t> entries_;  // Files by name.
  std::string prefix_;                           // Prefix of all keys.
};

}  // namespace

bool is_zip(std::string_view beginning) {
  return beginning.starts_with(std::string_view("PK\3\4", 4));
}

std::unique_ptr<ObjectStore> zip_store(const fs::path& file) {
  return std::make_unique<ZipStore>(file);
}

}  // namespace multitetra

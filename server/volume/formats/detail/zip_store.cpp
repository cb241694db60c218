#include "server/volume/formats/detail/zip_store.hpp"

#include <zip.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

[[noreturn]] void fail_in_zip(const fs::path& place, const std::string& problem) {
  fail_reading(place, problem, "Compare the archive with another copy, or pack it again");
}

Archive opened_archive(const fs::path& file) {
  (void)InputFile(file);  // Reports errors of the file itself.
  Archive archive(zip_open(file.c_str(), ZIP_RDONLY, nullptr), &zip_discard);
  if (!archive) fail_in_zip(file, "it is not a complete zip archive");
  return archive;
}

// A file in an archive, which is read forward; going back starts over.
class Entry {
 public:
  Entry(zip_t* archive, zip_uint64_t index, fs::path place)
      : archive_(archive), index_(index), place_(std::move(place)), stream_(nullptr, &zip_fclose) {
    zip_stat_t stat{};
    constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
    const bool is_known =
        zip_stat_index(archive, index, 0, &stat) == 0 && (stat.valid & kNeeded) == kNeeded;
    // Deflate compresses at most about a thousandfold.
    if (!is_known || stat.size / 1100 > stat.comp_size) {
      fail_in_zip(place_, "its sizes in the archive are invalid");
    }
    size_ = stat.size;
    is_stored_ = stat.comp_method == ZIP_CM_STORE;
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }

  // Requires that the entry has these bytes. Checks the checksum at the end of what is read from
  // the first byte on.
  void read(std::uint64_t offset, std::span<std::byte> into) {
    if (!stream_ || offset < at_) {
      stream_.reset(zip_fopen_index(archive_, index_, 0));
      at_ = 0;
    }
    if (!stream_) {
      fail_in_zip(place_, std::string("it cannot be read: ") + zip_strerror(archive_));
    }
    const bool is_sought =
        is_stored_ && offset > at_ &&
        zip_fseek(stream_.get(), static_cast<zip_int64_t>(offset), SEEK_SET) == 0;
    if (is_sought) at_ = offset;
    std::vector<std::byte> skipped(std::min<std::uint64_t>(offset - at_, std::uint64_t{1} << 20));
    while (at_ < offset) {
      take(std::span(skipped).first(std::min<std::uint64_t>(offset - at_, skipped.size())));
    }
    take(into);
  }

 private:
  void take(std::span<std::byte> bytes) {
    std::uint64_t done = 0;
    zip_int64_t count = 1;
    while (done < bytes.size() && count > 0) {
      count = zip_fread(stream_.get(), bytes.data() + done, bytes.size() - done);
      done += static_cast<std::uint64_t>(std::max<zip_int64_t>(count, 0));
    }
    at_ += done;
    std::byte none{};
    if (done == bytes.size() && at_ == size_) count = zip_fread(stream_.get(), &none, 1);
    const zip_error_t* const error = zip_file_get_error(stream_.get());
    if (count < 0 && zip_error_code_zip(error) == ZIP_ER_CRC) {
      fail_in_zip(place_, "its checksum (CRC-32) does not match");
    }
    if (done < bytes.size() || count < 0) {
      fail_in_zip(place_, "its bytes in the archive are damaged");
    }
  }

  zip_t* archive_;
  zip_uint64_t index_;
  fs::path place_;
  std::unique_ptr<zip_file_t, decltype(&zip_fclose)> stream_;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;  // Position in the stream.
  bool is_stored_ = false;
};

class SlicesInEntry : public StoredSlices {
 public:
  SlicesInEntry(const fs::path& file, const std::string& name, std::uint64_t offset, Endian endian,
                const ImageHeader& header)
      : archive_(opened_archive(file)),
        entry_(archive_.get(), index_of(name), file / name),
        offset_(offset),
        endian_(endian),
        header_(header) {
    if (entry_.size() >= offset && entry_.size() - offset >= header.volume_bytes()) return;
    fail_damaged(file / name, "it has fewer bytes than its shape needs");
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::size_t slice = header_.slice_bytes();
    const std::span<std::byte> all(into, count * slice);
    entry_.read(offset_ + first * slice, all);
    to_host_order(all, bytes_of(header_.type), endian_);
  }

 private:
  // The largest number is no index, which Entry reports.
  [[nodiscard]] zip_uint64_t index_of(const std::string& name) const {
    return static_cast<zip_uint64_t>(zip_name_locate(archive_.get(), name.c_str(), ZIP_FL_ENC_RAW));
  }

  Archive archive_;
  Entry entry_;
  std::uint64_t offset_;
  Endian endian_;
  ImageHeader header_;
};

class ZipStore : public ObjectStore {
 public:
  explicit ZipStore(const fs::path& file) : file_(file), archive_(opened_archive(file)) {
    const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(std::max<zip_int64_t>(count, 0)); ++i) {
      const char* const name = zip_get_name(archive_.get(), i, ZIP_FL_ENC_RAW);
      if (name != nullptr && !std::string_view(name).ends_with('/')) entries_[name] = i;
    }
    find_prefix();
  }

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    auto bytes = get_range(key, 0, most + 1);
    if (bytes && bytes->size() > most) {
      fail_in_zip(place(key), "it has more than " + std::to_string(most) + " bytes, the limit");
    }
    return bytes;
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    const auto entry = entries_.find(prefix_ + key);
    if (entry == entries_.end()) return std::nullopt;
    const std::lock_guard lock(mutex_);
    Entry opened(archive_.get(), entry->second, place(key));
    length = std::min(length, opened.size());
    if (offset == kFromEnd) offset = opened.size() - length;
    offset = std::min(offset, opened.size());
    std::vector<std::byte> bytes(std::min(length, opened.size() - offset));
    opened.read(offset, bytes);
    return bytes;
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
  Archive archive_;
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

std::unique_ptr<StoredSlices> slices_in_zip(const fs::path& file, const std::string& name,
                                            std::uint64_t offset, Endian endian,
                                            const ImageHeader& header) {
  return std::make_unique<SlicesInEntry>(file, name, offset, endian, header);
}

}  // namespace multitetra

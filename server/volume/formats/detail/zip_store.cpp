#include "server/volume/formats/detail/zip_store.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxDirectoryBytes = std::uint64_t{1} << 28;
constexpr std::uint32_t kInZip64 = 0xFFFFFFFF;

struct ZipEntry {
  bool is_deflated = false;
  std::uint32_t crc = 0;
  std::uint64_t packed = 0;
  std::uint64_t plain = 0;
  std::uint64_t header = 0;  // Offset of the local header.
};

class ZipStore : public ObjectStore {
 public:
  explicit ZipStore(const fs::path& file) : file_(file) {
    read_directory();
    find_prefix();
  }

  std::optional<std::vector<std::byte>> get(const std::string& key, std::uint64_t most) override {
    const ZipEntry* const entry = find(key);
    if (entry == nullptr) return std::nullopt;
    if (entry->plain > most) {
      fail(key, "it has " + std::to_string(entry->plain) + " bytes and may have " +
                    std::to_string(most));
    }
    return whole(key, *entry);
  }

  std::optional<std::vector<std::byte>> get_range(const std::string& key, std::uint64_t offset,
                                                  std::uint64_t length) override {
    const ZipEntry* const entry = find(key);
    if (entry == nullptr) return std::nullopt;
    length = std::min(length, entry->plain);
    if (offset == kFromEnd) offset = entry->plain - length;
    length = offset > entry->plain ? 0 : std::min(length, entry->plain - offset);
    if (entry->is_deflated) {
      constexpr std::uint64_t kMaxUnpackedBytes = std::uint64_t{1} << 28;
      if (entry->plain > kMaxUnpackedBytes) fail(key, "it is a large shard that is deflated");
      const std::vector<std::byte> all = whole(key, *entry);
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(offset);
      return std::vector<std::byte>(begin, begin + static_cast<std::ptrdiff_t>(length));
    }
    std::vector<std::byte> bytes(length);
    file_.read(data_of(key, *entry) + offset, bytes);
    return bytes;
  }

  [[nodiscard]] fs::path place(const std::string& key) const override { return file_.path() / key; }
  [[nodiscard]] std::size_t parallel_requests() const override { return 4; }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const {
    fail_reading(place(key), problem, "Get a whole copy of the archive");
  }

  HeaderBytes bytes_at(std::uint64_t offset, std::size_t count) const {
    std::string bytes(count, '\0');
    file_.read(offset, std::as_writable_bytes(std::span(bytes)));
    return {std::move(bytes), Endian::kLittle};
  }

  void read_directory() {
    constexpr std::size_t kEndBytes = 22;
    constexpr std::size_t kMaxCommentBytes = 65535;
    const auto count = static_cast<std::size_t>(
        std::min<std::uint64_t>(file_.size(), kEndBytes + kMaxCommentBytes));
    std::string tail(count, '\0');
    file_.read(file_.size() - count, std::as_writable_bytes(std::span(tail)));
    const std::size_t found = tail.rfind(std::string_view("PK\5\6", 4));
    if (found == std::string::npos || tail.size() - found < kEndBytes) {
      fail("", "it is no whole zip archive");
    }
    const std::uint64_t end = file_.size() - count + found;
    const HeaderBytes record = bytes_at(end, kEndBytes);
    std::uint64_t size = record.at<std::uint32_t>(12);
    std::uint64_t offset = record.at<std::uint32_t>(16);
    if (offset == kInZip64 || record.at<std::uint16_t>(10) == 0xFFFF) {
      if (end < 20) fail("", "it is no whole zip archive");
      const std::uint64_t large = bytes_at(end - 20, 20).at<std::uint64_t>(8);
      const HeaderBytes long_record = bytes_at(large, 56);
      size = long_record.at<std::uint64_t>(40);
      offset = long_record.at<std::uint64_t>(48);
    }
    if (size > kMaxDirectoryBytes || offset > file_.size() || size > file_.size() - offset) {
      fail("", "the directory of this zip archive is damaged");
    }
    std::string directory(size, '\0');
    file_.read(offset, std::as_writable_bytes(std::span(directory)));
    std::string_view rest = directory;
    while (!rest.empty()) read_entry(rest);
  }

  // Parses an entry of the directory and removes it from `rest`.
  void read_entry(std::string_view& rest) {
    constexpr std::size_t kHeadBytes = 46;
    if (rest.size() < kHeadBytes || !rest.starts_with(std::string_view("PK\1\2", 4))) {
      fail("", "the directory of this zip archive is damaged");
    }
    const HeaderBytes head(std::string(rest.substr(0, kHeadBytes)), Endian::kLittle);
    const std::size_t name_bytes = head.at<std::uint16_t>(28);
    const std::size_t extra_bytes = head.at<std::uint16_t>(30);
    const std::size_t all = kHeadBytes + name_bytes + extra_bytes + head.at<std::uint16_t>(32);
    if (rest.size() < all) fail("", "the directory of this zip archive is damaged");
    const std::string name(rest.substr(kHeadBytes, name_bytes));
    ZipEntry entry{.is_deflated = head.at<std::uint16_t>(10) == 8,
                   .crc = head.at<std::uint32_t>(16),
                   .packed = head.at<std::uint32_t>(20),
                   .plain = head.at<std::uint32_t>(24),
                   .header = head.at<std::uint32_t>(42)};
    read_large_sizes(rest.substr(kHeadBytes + name_bytes, extra_bytes), entry);
    const auto method = head.at<std::uint16_t>(10);
    if ((head.at<std::uint16_t>(8) & 1) != 0 || (method != 0 && method != 8)) {
      fail(name, "it is encrypted, or packed by another method than deflate");
    }
    if (!name.ends_with('/')) entries_[name] = entry;
    rest.remove_prefix(all);
  }

  static void read_large_sizes(std::string_view extra, ZipEntry& entry) {
    while (extra.size() >= 4) {
      const HeaderBytes head(std::string(extra.substr(0, 4)), Endian::kLittle);
      const std::size_t size = head.at<std::uint16_t>(2);
      if (extra.size() < 4 + size) return;
      if (head.at<std::uint16_t>(0) == 1) {
        std::string_view numbers = extra.substr(4, size);
        for (std::uint64_t* number : {&entry.plain, &entry.packed, &entry.header}) {
          if (*number != kInZip64 || numbers.size() < 8) continue;
          std::memcpy(number, numbers.data(), 8);  // Requires a little-endian host.
          numbers.remove_prefix(8);
        }
      }
      extra.remove_prefix(4 + size);
    }
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

  [[nodiscard]] const ZipEntry* find(const std::string& key) const {
    const auto found = entries_.find(prefix_ + key);
    return found == entries_.end() ? nullptr : &found->second;
  }

  [[nodiscard]] std::uint64_t data_of(const std::string& key, const ZipEntry& entry) const {
    if (entry.header > file_.size()) fail(key, "it begins beyond the end of the archive");
    const HeaderBytes local = bytes_at(entry.header, 30);
    if (local.at<std::uint32_t>(0) != 0x04034B50) fail(key, "its header in the archive is damaged");
    const std::uint64_t data =
        entry.header + 30 + local.at<std::uint16_t>(26) + local.at<std::uint16_t>(28);
    if (data > file_.size() || entry.packed > file_.size() - data) {
      fail(key, "it begins beyond the end of the archive");
    }
    return data;
  }

  [[nodiscard]] std::vector<std::byte> whole(const std::string& key, const ZipEntry& entry) const {
    const std::uint64_t data = data_of(key, entry);
    // Deflate compresses at most about a thousandfold.
    if (entry.plain / 1100 > entry.packed || (!entry.is_deflated && entry.plain != entry.packed)) {
      fail(key, "its sizes in the archive are damaged");
    }
    std::vector<std::byte> plain(entry.plain);
    if (entry.is_deflated) {
      std::vector<std::byte> packed(entry.packed);
      file_.read(data, packed);
      if (!unpack(Packing::kDeflate, packed, plain)) fail(key, "its packed bytes are damaged");
    } else {
      file_.read(data, plain);
    }
    const auto crc =
        ::crc32_z(0, reinterpret_cast<const unsigned char*>(plain.data()), plain.size());
    if (crc != entry.crc) fail(key, "its checksum (CRC-32) is wrong");
    return plain;
  }

  InputFile file_;
  std::map<std::string, ZipEntry> entries_;
  std::string prefix_;  // Prefix of all keys.
};

}  // namespace

bool is_zip(std::string_view beginning) {
  return beginning.starts_with(std::string_view("PK\3\4", 4));
}

std::unique_ptr<ObjectStore> zip_store(const fs::path& file) {
  return std::make_unique<ZipStore>(file);
}

}  // namespace multitetra

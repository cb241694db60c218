#include "server/dataset/payload_size.hpp"

#include <zlib.h>

#include <array>
#include <cctype>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "server/dataset/image_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kUnpackedPortionBytes = std::size_t{1} << 18;

std::ifstream opened_at(const fs::path& file, std::uint64_t offset) {
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(offset));
  return in;
}

constexpr int kGzipFirstByte = 0x1f;

bool is_gzip(const std::array<unsigned char, 2>& first) {
  return first[0] == kGzipFirstByte && first[1] == 0x8b;
}

bool starts_stream(const std::array<unsigned char, 2>& first) {
  const bool zlib = (first[0] & 0x0f) == 8 && (first[0] * 256 + first[1]) % 31 == 0;
  return is_gzip(first) || zlib;
}

// Owns zlib's state.
class Inflater {
 public:
  Inflater() { inflateInit2(&stream_, 15 + 32); }  // Tells zlib from gzip by itself.
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  z_stream* operator->() { return &stream_; }
  int run() { return inflate(&stream_, Z_NO_FLUSH); }
  int begin_next_member() { return inflateReset(&stream_); }

 private:
  z_stream stream_{};
};

// Numbers of a TIFF file, in its byte order; reading beyond the end makes `good` false.
class TiffNumbers {
 public:
  explicit TiffNumbers(const fs::path& file) : in_(file, std::ios::binary) {
    little_ = number(0, 1) == 'I';
  }
  std::uint64_t number(std::uint64_t offset, std::size_t bytes) {
    std::array<unsigned char, 8> raw{};
    in_.seekg(static_cast<std::streamoff>(offset));
    in_.read(reinterpret_cast<char*>(raw.data()), static_cast<std::streamsize>(bytes));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      value = value << 8 | raw[little_ ? bytes - 1 - i : i];
    }
    return value;
  }
  [[nodiscard]] bool good() const { return in_.good(); }

 private:
  std::ifstream in_;
  bool little_ = false;
};

}  // namespace

void require_whole(const fs::path& file, std::uint64_t found, std::uint64_t needed,
                   std::string_view what) {
  if (found >= needed) return;
  fail_reading(file,
               "it ends too early or is damaged; its header promises " + std::to_string(needed) +
                   " " + std::string(what) + " and " + std::to_string(found) + " are there",
               "Get a whole copy of it");
}

std::optional<std::uint64_t> inflated_bytes(const fs::path& file, std::uint64_t offset) {
  std::ifstream in = opened_at(file, offset);
  std::array<unsigned char, 2> first{};
  in.read(reinterpret_cast<char*>(first.data()), 2);
  if (!in || !starts_stream(first)) return bytes_after(file, offset);
  in.seekg(static_cast<std::streamoff>(offset));

  Inflater inflater;
  std::vector<char> packed(kUnpackedPortionBytes);
  std::vector<unsigned char> unpacked(kUnpackedPortionBytes);
  std::uint64_t total = 0;
  int state = Z_OK;
  while (state == Z_OK) {
    if (inflater->avail_in == 0) {
      in.read(packed.data(), static_cast<std::streamsize>(packed.size()));
      inflater->next_in = reinterpret_cast<unsigned char*>(packed.data());
      inflater->avail_in = static_cast<unsigned>(in.gcount());
      if (inflater->avail_in == 0) return std::nullopt;  // The stream goes on, the file does not.
    }
    inflater->next_out = unpacked.data();
    inflater->avail_out = static_cast<unsigned>(unpacked.size());
    state = inflater.run();
    total += unpacked.size() - inflater->avail_out;
    if (state == Z_STREAM_END && is_gzip(first)) {  // It may have several members.
      const int next = inflater->avail_in > 0 ? *inflater->next_in : in.peek();
      if (next == kGzipFirstByte) state = inflater.begin_next_member();
    }
  }
  if (state != Z_STREAM_END) return std::nullopt;
  return total;
}

std::uint64_t numbers_in_text(const fs::path& file, std::uint64_t offset, std::uint64_t enough) {
  std::ifstream in = opened_at(file, offset);
  std::vector<char> portion(kUnpackedPortionBytes);
  std::uint64_t words = 0;
  bool in_word = false;
  while (words <= enough) {
    in.read(portion.data(), static_cast<std::streamsize>(portion.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    if (count == 0) break;
    for (std::size_t i = 0; i < count; ++i) {
      const bool space = std::isspace(static_cast<unsigned char>(portion[i])) != 0;
      if (!space && !in_word) {
        const bool numeric = std::strchr("0123456789+-.nNiI", portion[i]) != nullptr;
        if (!numeric || portion[i] == '\0') return words;
        ++words;
      }
      in_word = !space;
    }
  }
  return words < enough ? words : enough;
}

bool tiff_directories_are_whole(const fs::path& file) {
  TiffNumbers tiff(file);
  const bool big = tiff.number(2, 2) == 43;  // BigTIFF: 64-bit counts and offsets.
  const std::uint64_t entry_bytes = big ? 20 : 12;
  const std::size_t count_bytes = big ? 8 : 2;
  const std::size_t offset_bytes = big ? 8 : 4;
  const std::uint64_t most_pages = bytes_after(file, 0) / entry_bytes + 1;  // More is a cycle.
  std::uint64_t directory = tiff.number(big ? 8 : 4, offset_bytes);
  for (std::uint64_t page = 0; directory != 0 && tiff.good(); ++page) {
    if (page > most_pages) return false;
    const std::uint64_t entries = tiff.number(directory, count_bytes);
    directory = tiff.number(directory + count_bytes + entries * entry_bytes, offset_bytes);
  }
  return tiff.good();
}

std::uint64_t bytes_after(const fs::path& file, std::uint64_t offset) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return error || size < offset ? 0 : size - offset;
}

}  // namespace multitetra

#include "server/volume/formats/vtk/vtk_arrays.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/text_slices.hpp"
#include "server/volume/formats/detail/unpacking.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kXmlPortionBytes = std::size_t{1} << 16;

// Bytes of a file from an offset, raw or as contiguous base64.
class EncodedBytes {
 public:
  EncodedBytes(const InputFile& file, std::uint64_t begin, bool is_base64)
      : file_(&file), begin_(begin), is_base64_(is_base64) {}

  void read(std::uint64_t offset, std::span<std::byte> into) const {
    if (!is_base64_) return file_->read(begin_ + offset, into);
    constexpr std::size_t kPortion = std::size_t{3} << 18;
    while (!into.empty()) {
      const std::size_t count = std::min(into.size(), kPortion);
      read_base64(offset, into.first(count));
      offset += count;
      into = into.subspan(count);
    }
  }

  // Returns whether the first `count` bytes are encoded apart from what follows: padding then fills
  // their last group. Requires a count that is no multiple of 3, with other bytes behind it.
  [[nodiscard]] bool ends_after(std::uint64_t count) const {
    if (!is_base64_) return false;
    std::array<std::byte, 4> group{};
    file_->read(begin_ + count / 3 * 4, group);
    return group[3] == std::byte{'='} && (group[2] == std::byte{'='}) == (count % 3 == 1);
  }

  // Returns the bytes from `offset` on. With base64, a separately encoded run must begin there.
  [[nodiscard]] EncodedBytes after(std::uint64_t offset) const {
    return {*file_, begin_ + (is_base64_ ? (offset + 2) / 3 * 4 : offset), is_base64_};
  }

 private:
  void read_base64(std::uint64_t offset, std::span<std::byte> into) const {
    const std::uint64_t first_group = offset / 3;
    const std::uint64_t last_group = (offset + into.size() - 1) / 3;
    std::vector<std::byte> text(4 * (last_group - first_group + 1));
    file_->read(begin_ + 4 * first_group, text);
    std::uint64_t at = 3 * first_group;
    for (std::size_t group = 0; group < text.size(); group += 4) {
      std::uint32_t bits = 0;
      for (std::size_t i = 0; i < 4; ++i) bits = bits << 6 | digit(text[group + i], i);
      for (int shift = 16; shift >= 0; shift -= 8, ++at) {
        if (at < offset || at >= offset + into.size()) continue;
        if (text[group + static_cast<std::size_t>(3 - shift / 8)] == std::byte{'='}) {
          fail_in_base64();
        }
        into[at - offset] = static_cast<std::byte>(bits >> shift & 0xFF);
      }
    }
  }

  [[nodiscard]] std::uint32_t digit(std::byte byte, std::size_t place) const {
    const char c = static_cast<char>(byte);
    if (c >= 'A' && c <= 'Z') return static_cast<std::uint32_t>(c - 'A');
    if (c >= 'a' && c <= 'z') return static_cast<std::uint32_t>(c - 'a') + 26;
    if (c >= '0' && c <= '9') return static_cast<std::uint32_t>(c - '0') + 52;
    if (c == '+') return 62;
    if (c == '/') return 63;
    if (c == '=' && place >= 2) return 0;
    fail_in_base64();
  }

  [[noreturn]] void fail_in_base64() const {
    fail_reading(file_->path(),
                 "its base64 data contain an invalid byte, or end within the samples",
                 "Save it again with appended raw data");
  }

  const InputFile* file_;
  std::uint64_t begin_;
  bool is_base64_;
};

class Lengths {
 public:
  Lengths(const EncodedBytes& bytes, const VtiHeader& header)
      : bytes_(bytes),
        width_(static_cast<std::size_t>(header.length_bytes)),
        endian_(header.endian) {}

  [[nodiscard]] std::size_t width() const { return width_; }
  [[nodiscard]] std::vector<std::uint64_t> read(std::uint64_t first, std::uint64_t count) const {
    std::vector<std::byte> raw(count * width_);
    bytes_.read(first * width_, raw);
    to_host_order(raw, width_, endian_);
    std::vector<std::uint64_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::memcpy(&numbers[i], raw.data() + i * width_, width_);  // Requires a little-endian host.
    }
    return numbers;
  }

 private:
  EncodedBytes bytes_;
  std::size_t width_;
  Endian endian_;
};

class PlainSampleBytes : public SampleBytes {
 public:
  PlainSampleBytes(const InputFile& file, const EncodedBytes& bytes, const VtiHeader& header,
                   std::size_t sample_width, std::uint64_t needed)
      : bytes_(bytes), endian_(header.endian), width_(sample_width) {
    const Lengths lengths(bytes, header);
    skipped_ = lengths.width();
    const std::uint64_t found = lengths.read(0, 1)[0];
    if (found == needed) {
      // Writers encode the length and the samples together, as VTK does, or apart.
      if (!bytes.ends_after(skipped_)) return;
      bytes_ = bytes.after(skipped_);
      skipped_ = 0;
      return;
    }
    fail_damaged(file.path(), "its header declares " + std::to_string(needed) +
                                  " bytes of samples, but the array has " + std::to_string(found));
  }

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    bytes_.read(skipped_ + offset, into);
    to_host_order(into, width_, endian_);
  }

 private:
  EncodedBytes bytes_;
  Endian endian_;
  std::size_t width_;
  std::uint64_t skipped_ = 0;
};

class PackedSampleBytes : public SampleBytes {
 public:
  PackedSampleBytes(const InputFile& file, const EncodedBytes& bytes, const VtiHeader& header,
                    Packing packing, std::size_t sample_width, std::uint64_t needed)
      : file_(file),
        blocks_(bytes),
        packing_(packing),
        endian_(header.endian),
        width_(sample_width) {
    const Lengths lengths(bytes, header);
    const std::vector<std::uint64_t> head = lengths.read(0, 3);
    const std::uint64_t count = head[0];
    block_bytes_ = head[1];
    last_bytes_ = head[2] != 0 ? head[2] : head[1];
    constexpr std::uint64_t kMaxBlockBytes = std::uint64_t{1} << 31;
    if (count == 0 || count > needed || block_bytes_ == 0 || block_bytes_ > kMaxBlockBytes ||
        last_bytes_ > block_bytes_ || (count - 1) * block_bytes_ + last_bytes_ != needed ||
        block_bytes_ % sample_width != 0) {
      fail_damaged(file.path(), "its " + std::to_string(count) + " compressed blocks of " +
                                    std::to_string(block_bytes_) + " bytes do not make up the " +
                                    std::to_string(needed) +
                                    " bytes of samples that its header declares");
    }
    if (count * lengths.width() > file.size()) {
      fail_incomplete(file.path(), "it ends within the sizes of its compressed blocks");
    }
    begins_.push_back(0);
    for (const std::uint64_t size : lengths.read(3, count)) {
      if (size > file.size()) {
        fail_damaged(file.path(), "a compressed block is larger than the file");
      }
      begins_.push_back(begins_.back() + size);
    }
    blocks_ = bytes.after((3 + count) * lengths.width());
  }

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    while (!into.empty()) {
      const std::uint64_t block = offset / block_bytes_;
      load(block);
      const std::uint64_t in_block = offset % block_bytes_;
      const std::size_t count = std::min<std::uint64_t>(into.size(), plain_.size() - in_block);
      std::memcpy(into.data(), plain_.data() + in_block, count);
      offset += count;
      into = into.subspan(count);
    }
  }

 private:
  void load(std::uint64_t block) {
    if (block == loaded_) return;
    packed_.resize(begins_[block + 1] - begins_[block]);
    plain_.resize(block + 2 == begins_.size() ? last_bytes_ : block_bytes_);
    blocks_.read(begins_[block], packed_);
    loaded_ = ~std::uint64_t{0};
    if (const auto done = unpack(packing_, packed_, plain_); !done) {
      fail_damaged(file_.path(), "its compressed block " + std::to_string(block) +
                                     " cannot be decompressed: " + done.error().text);
    }
    to_host_order(plain_, width_, endian_);
    loaded_ = block;
  }

  const InputFile& file_;
  EncodedBytes blocks_;
  Packing packing_;
  Endian endian_;
  std::size_t width_;
  std::uint64_t block_bytes_ = 0;
  std::uint64_t last_bytes_ = 0;
  std::vector<std::uint64_t> begins_;  // Begin of each packed block, and end of the last one.
  std::uint64_t loaded_ = ~std::uint64_t{0};
  std::vector<std::byte> packed_;
  std::vector<std::byte> plain_;
};

// Numbers as text, each a slice of its own.
class TextSampleBytes : public SampleBytes {
 public:
  TextSampleBytes(const InputFile& file, const VtiArray& array, std::uint64_t count)
      : file_(file.path()),
        width_(bytes_of(array.type)),
        numbers_(text_slices(
            {.file = file.path(), .begin = array.begin, .end = array.end, .are_all = true},
            {.dims = {1, 1, static_cast<std::int64_t>(count)},
             .type = array.type,
             .values = kNumbersAsStored})) {}

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    numbers_->read(offset / width_, into.size() / width_, into.data());
    if (numbers_->findings().empty()) return;
    fail_damaged(file_, "an array has more numbers than its header declares");
  }

 private:
  fs::path file_;
  std::size_t width_;
  std::unique_ptr<StoredSlices> numbers_;
};

VtiHeader read_header(const InputFile& file, VtkDataKind kind) {
  std::string portion;
  std::uint64_t at = 0;
  const auto next = [&]() -> std::string_view {
    portion.resize(kXmlPortionBytes);
    portion.resize(file.read_some(at, std::as_writable_bytes(std::span(portion))));
    at += portion.size();
    return portion;
  };
  Result<VtiHeader> header = parse_vti(next, kind);
  if (!header) {
    fail_reading(file.path(), header.error().text,
                 "Save it as one piece, for example with ParaView");
  }
  return *std::move(header);
}

// Returns the start of base64 or text between tags, after white space.
std::uint64_t behind_white_space(const InputFile& file, const VtiArray& array) {
  std::array<std::byte, 256> first{};
  const std::size_t count = file.read_some(array.begin, first);
  for (std::size_t i = 0; i < count; ++i) {
    const char c = static_cast<char>(first[i]);
    if (c != ' ' && c != '\t' && c != '\r' && c != '\n') return array.begin + i;
  }
  return array.begin;
}

}  // namespace

VtkArrays::VtkArrays(const fs::path& file, VtkDataKind kind)
    : file_(file), header_(read_header(file_, kind)) {}

std::unique_ptr<SampleBytes> VtkArrays::open(const VtiArray& array, std::uint64_t count) const {
  if (array.format == VtiArray::Format::kText)
    return std::make_unique<TextSampleBytes>(file_, array, count);
  if (array.format == VtiArray::Format::kAppended && !header_.appended) {
    fail_damaged(file_.path(), "it has no appended data");
  }
  const bool appended = array.format == VtiArray::Format::kAppended;
  const EncodedBytes bytes(
      file_, appended ? *header_.appended + array.begin : behind_white_space(file_, array),
      !appended || !header_.appended_raw);
  const std::size_t width = bytes_of(array.type);
  const std::uint64_t needed = count * width;
  if (header_.compressor.empty()) {
    return std::make_unique<PlainSampleBytes>(file_, bytes, header_, width, needed);
  }
  const bool is_zlib = header_.compressor == "vtkZLibDataCompressor";
  if (!is_zlib && header_.compressor != "vtkLZ4DataCompressor") {
    fail_reading(file_.path(), "it is compressed with '" + header_.compressor.substr(0, 60) + "'",
                 "Save it with ZLib or LZ4, or without a compressor");
  }
  return std::make_unique<PackedSampleBytes>(
      file_, bytes, header_, is_zlib ? Packing::kZlib : Packing::kLz4, width, needed);
}

}  // namespace multitetra

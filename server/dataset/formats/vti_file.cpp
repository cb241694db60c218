#include "server/dataset/formats/vti_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/dataset/formats/input_file.hpp"
#include "server/dataset/formats/unpacking.hpp"
#include "server/dataset/formats/vti_header.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kXmlPortionBytes = std::size_t{1} << 16;

// Bytes in a file from some place on, as they are or as base64 without anything in between.
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

  // The same bytes seen from `offset` on. In base64 what is encoded on its own begins there.
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
    fail_reading(file_->path(), "its base64 has a byte that has no place there",
                 "Save it anew with appended raw data");
  }

  const InputFile* file_;
  std::uint64_t begin_;
  bool is_base64_;
};

// The samples of an array as bytes, whatever is around them.
class SampleBytes {
 public:
  virtual ~SampleBytes() = default;
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;  // In host order.
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
      std::memcpy(&numbers[i], raw.data() + i * width_, width_);  // Little-endian hosts only.
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
    if (found == needed) return;
    fail_reading(file.path(),
                 "its extent promises " + std::to_string(needed) +
                     " bytes of samples and the array has " + std::to_string(found),
                 "Get a whole copy of it");
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
    constexpr std::uint64_t kMostBlockBytes = std::uint64_t{1} << 31;
    if (count == 0 || count > needed || block_bytes_ == 0 || block_bytes_ > kMostBlockBytes ||
        last_bytes_ > block_bytes_ || (count - 1) * block_bytes_ + last_bytes_ != needed ||
        block_bytes_ % sample_width != 0) {
      fail_reading(file.path(),
                   "its " + std::to_string(count) + " packed blocks of " +
                       std::to_string(block_bytes_) + " bytes are not the " +
                       std::to_string(needed) + " bytes of samples that its extent promises",
                   "Get a whole copy of it");
    }
    if (count * lengths.width() > file.size()) {
      fail_reading(file.path(), "it ends in the sizes of its packed blocks",
                   "Get a whole copy of it");
    }
    begins_.push_back(0);
    for (const std::uint64_t size : lengths.read(3, count)) {
      if (size > file.size()) {
        fail_reading(file.path(), "a packed block is larger than the file",
                     "Get a whole copy of it");
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
      fail_reading(
          file_.path(),
          "its packed block " + std::to_string(block) + " cannot be used: " + done.error().text,
          "Get a whole copy of it");
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
  std::vector<std::uint64_t> begins_;  // Where packed blocks begin, and where the last one ends.
  std::uint64_t loaded_ = ~std::uint64_t{0};
  std::vector<std::byte> packed_;
  std::vector<std::byte> plain_;
};

// Numbers as text: read forwards, begun anew to go back.
class TextSampleBytes : public SampleBytes {
 public:
  TextSampleBytes(const InputFile& file, const VtiArray& array)
      : file_(file), array_(array), at_(array.begin) {}

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    const std::uint64_t first = offset / bytes_of(array_.type);
    if (first < next_) {
      at_ = array_.begin;
      next_ = 0;
      text_.clear();
      used_ = 0;
    }
    while (next_ < first) next_number();
    const std::size_t width = bytes_of(array_.type);
    for (std::size_t at = 0; at < into.size(); at += width) {
      store(next_number(), into.data() + at);
    }
  }

 private:
  std::string_view next_number() {
    while (true) {
      used_ = text_.find_first_not_of(" \t\r\n", used_);
      if (used_ != std::string::npos) {
        const std::size_t end = text_.find_first_of(" \t\r\n", used_);
        if (end != std::string::npos || at_ == array_.end) {
          const std::string_view word = std::string_view(text_).substr(used_, end - used_);
          used_ = end;
          ++next_;
          return word;
        }
        text_.erase(0, used_);
      } else {
        text_.clear();
      }
      used_ = 0;
      if (at_ >= array_.end || text_.size() > kXmlPortionBytes) {
        fail_reading(file_.path(),
                     "its text ends after " + std::to_string(next_) + " numbers or is damaged",
                     "Get a whole copy of it");
      }
      const std::size_t before = text_.size();
      const std::size_t count = std::min<std::uint64_t>(kXmlPortionBytes, array_.end - at_);
      text_.resize(before + count);
      file_.read(at_, std::as_writable_bytes(std::span(text_).subspan(before)));
      at_ += count;
    }
  }

  void store(std::string_view word, std::byte* into) const {
    const auto put = [&]<typename Number>(Number number) {
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
      if (error != std::errc() || end != word.data() + word.size()) {
        fail_reading(file_.path(),
                     "'" + std::string(word.substr(0, 40)) + "' is no number of type " +
                         std::string(name(array_.type)),
                     "Correct the file");
      }
      std::memcpy(into, &number, sizeof(number));
    };
    switch (array_.type) {
      case StoredType::kU8:
        return put(std::uint8_t{});
      case StoredType::kI8:
        return put(std::int8_t{});
      case StoredType::kU16:
        return put(std::uint16_t{});
      case StoredType::kI16:
        return put(std::int16_t{});
      case StoredType::kF32:
        return put(float{});
      case StoredType::kU32:
        return put(std::uint32_t{});
      case StoredType::kI32:
        return put(std::int32_t{});
      case StoredType::kU64:
        return put(std::uint64_t{});
      case StoredType::kI64:
        return put(std::int64_t{});
      case StoredType::kF64:
        return put(double{});
    }
  }

  const InputFile& file_;
  VtiArray array_;
  std::uint64_t at_;  // The file's byte that comes after text_.
  std::string text_;
  std::size_t used_ = 0;    // Of text_.
  std::uint64_t next_ = 0;  // The number that comes next.
};

class VtiSlices : public StoredSlices {
 public:
  VtiSlices(std::unique_ptr<InputFile> file, std::unique_ptr<SampleBytes> bytes,
            std::size_t slice_bytes)
      : file_(std::move(file)), bytes_(std::move(bytes)), slice_bytes_(slice_bytes) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    bytes_->read(first * slice_bytes_, {into, count * slice_bytes_});
  }

 private:
  std::unique_ptr<InputFile> file_;
  std::unique_ptr<SampleBytes> bytes_;
  std::size_t slice_bytes_;
};

VtiHeader read_header(const InputFile& file) {
  std::string portion;
  std::uint64_t at = 0;
  const auto next = [&]() -> std::string_view {
    portion.resize(kXmlPortionBytes);
    portion.resize(file.read_some(at, std::as_writable_bytes(std::span(portion))));
    at += portion.size();
    return portion;
  };
  Result<VtiHeader> header = parse_vti(next);
  if (!header) {
    fail_reading(file.path(), header.error().text,
                 "Save it as one piece of ImageData, for example with ParaView");
  }
  return *std::move(header);
}

const VtiArray& chosen(const fs::path& file, const VtiHeader& header, const std::string& wanted) {
  std::string names;
  for (const VtiArray& array : header.arrays) names += (names.empty() ? "" : ", ") + array.name;
  if (header.arrays.empty()) {
    fail_reading(file, "it has no arrays of numbers", "Save it with point data");
  }
  const auto find = [&](const std::string& name, bool of_cells) {
    return std::find_if(header.arrays.begin(), header.arrays.end(), [&](const VtiArray& array) {
      return array.of_cells == of_cells && (name.empty() || array.name == name);
    });
  };
  for (const bool of_cells : {false, true}) {
    const std::string& scalars = of_cells ? header.cell_scalars : header.scalars;
    auto found = find(wanted.empty() ? scalars : wanted, of_cells);
    if (found == header.arrays.end() && wanted.empty()) found = find("", of_cells);
    if (found != header.arrays.end()) return *found;
  }
  fail_reading(file, "it has no array '" + wanted + "'", "Its arrays are " + names);
}

// The arrays beside the chosen one that have as many samples.
SourceMembers members_beside(const VtiHeader& header, const VtiArray& chosen) {
  SourceMembers members;
  for (const VtiArray& array : header.arrays) {
    if (array.of_cells != chosen.of_cells || members.fields.size() == kMostSourceMembers) continue;
    const std::string name = member_name_from(array.name);
    if (name.empty()) {
      members.unnamed.push_back(array.name);
    } else {
      members.fields.push_back({.name = name, .array = array.name, .components = array.components});
    }
  }
  return members;
}

// Where base64 or text between tags really begins: behind white space.
std::uint64_t behind_white_space(const InputFile& file, const VtiArray& array) {
  std::array<std::byte, 256> first{};
  const std::size_t count = file.read_some(array.begin, first);
  for (std::size_t i = 0; i < count; ++i) {
    const char c = static_cast<char>(first[i]);
    if (c != ' ' && c != '\t' && c != '\r' && c != '\n') return array.begin + i;
  }
  return array.begin;
}

std::unique_ptr<SampleBytes> sample_bytes(const InputFile& file, const VtiHeader& header,
                                          const VtiArray& array, std::uint64_t needed) {
  if (array.format == VtiArray::Format::kText)
    return std::make_unique<TextSampleBytes>(file, array);
  if (array.format == VtiArray::Format::kAppended && !header.appended) {
    fail_reading(file.path(), "it has no appended data", "Get a whole copy of it");
  }
  const bool appended = array.format == VtiArray::Format::kAppended;
  const EncodedBytes bytes(
      file, appended ? *header.appended + array.begin : behind_white_space(file, array),
      !appended || !header.appended_raw);
  const std::size_t width = bytes_of(array.type);
  if (header.compressor.empty()) {
    return std::make_unique<PlainSampleBytes>(file, bytes, header, width, needed);
  }
  const bool is_zlib = header.compressor == "vtkZLibDataCompressor";
  if (!is_zlib && header.compressor != "vtkLZ4DataCompressor") {
    fail_reading(file.path(), "it is packed by '" + header.compressor.substr(0, 60) + "'",
                 "Save it with ZLib or LZ4, or without a compressor");
  }
  return std::make_unique<PackedSampleBytes>(
      file, bytes, header, is_zlib ? Packing::kZlib : Packing::kLz4, width, needed);
}

}  // namespace

VtiPiece open_vti_piece(const fs::path& path, const VolumeChoice& choice) {
  auto file = std::make_unique<InputFile>(path);
  const VtiHeader vti = read_header(*file);
  const VtiArray& array = chosen(path, vti, choice.array);

  ImageHeader header{.type = array.type, .components = array.components};
  std::array<Vec3, 3> steps{};
  Vec3 origin = vti.origin;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t low = vti.piece[2 * axis];
    header.dims[axis] = vti.piece[2 * axis + 1] - low + (array.of_cells ? 0 : 1);
    const double first = static_cast<double>(low) + (array.of_cells ? 0.5 : 0.0);
    for (std::size_t row = 0; row < 3; ++row) {
      steps[axis][row] = vti.directions[axis][row] * vti.spacing[axis];
      origin[row] += steps[axis][row] * first;
    }
  }
  set_axes(path, header, steps, origin);
  check_header(path, header);
  const std::uint64_t needed = header.slice_bytes() * static_cast<std::uint64_t>(header.dims[2]);
  auto bytes = sample_bytes(*file, vti, array, needed);
  const std::size_t slice_bytes = header.slice_bytes();
  StoredVolume volume{
      .header = header,
      .slices = std::make_unique<VtiSlices>(std::move(file), std::move(bytes), slice_bytes),
      .members = members_beside(vti, array)};
  if (vti.arrays.size() > 1 && choice.array.empty()) {
    volume.notices.push_back("'" + path.string() + "': of its " +
                             std::to_string(vti.arrays.size()) + " arrays '" + array.name +
                             "' is taken; --array chooses, --field makes a dataset of each.");
  }
  return {.volume = std::move(volume),
          .extent = vti.piece,
          .of_cells = array.of_cells,
          .is_part = vti.piece != vti.extent};
}

StoredVolume open_vti(const fs::path& path, const VolumeChoice& choice) {
  VtiPiece piece = open_vti_piece(path, choice);
  if (!piece.is_part) return std::move(piece.volume);
  fail_reading(path, "it is a piece of a larger image",
               "Give the .pvti file that names its pieces");
}

}  // namespace multitetra

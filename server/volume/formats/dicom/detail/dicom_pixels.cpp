#include "server/volume/formats/dicom/detail/dicom_pixels.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kUndefinedLength = 0xFFFFFFFF;
constexpr std::string_view kRleSyntax = "1.2.840.10008.1.2.5";
constexpr std::string_view kBigEndianSyntax = "1.2.840.10008.1.2.2";

[[noreturn]] void fail_cut_off(const InputFile& file, const std::string& how) {
  fail_incomplete(file.path(), "its pixel data are truncated: " + how);
}

struct Fragment {
  std::uint64_t offset;
  std::uint32_t length;
};

// Returns the fragments after the offset table.
std::vector<Fragment> fragments_at(const InputFile& file, std::uint64_t at) {
  constexpr std::uint32_t kItem = 0xE000FFFE;
  constexpr std::uint32_t kEnd = 0xE0DDFFFE;
  std::vector<Fragment> fragments;
  while (true) {
    std::string head(8, '\0');
    const std::size_t got = file.read_some(at, std::as_writable_bytes(std::span(head)));
    // Some writers omit the end marker, so the file ends with a fragment.
    if (got == 0 && fragments.size() > 1) break;
    if (got < head.size()) fail_cut_off(file, "the file ends within its fragments");
    const HeaderBytes bytes(head, Endian::kLittle);
    const auto tag = bytes.at<std::uint32_t>(0);
    const auto length = bytes.at<std::uint32_t>(4);
    if (tag == kEnd) break;
    if (tag != kItem) {
      fail_damaged(file.path(), "its compressed pixel data are damaged");
    }
    at += head.size();
    if (at + length > file.size()) fail_cut_off(file, "the file ends within a compressed frame");
    fragments.push_back({.offset = at, .length = length});
    at += length;
  }
  if (!fragments.empty()) fragments.erase(fragments.begin());
  return fragments;
}

// All kinds of JPEG end with the same marker, possibly followed by padding.
bool ends_as_jpeg(const InputFile& file, const Fragment& fragment) {
  std::array<std::byte, 64> bytes{};
  const std::size_t count = std::min<std::size_t>(fragment.length, bytes.size());
  file.read(fragment.offset + fragment.length - count, std::span(bytes).first(count));
  std::size_t end = count;
  const auto is_padding = [](std::byte byte) {
    return byte == std::byte{0} || byte == std::byte{0xFF};
  };
  while (end > 0 && is_padding(bytes[end - 1])) --end;
  return end >= 2 && bytes[end - 2] == std::byte{0xFF} && bytes[end - 1] == std::byte{0xD9};
}

// Returns whether the PackBits segment unpacks to at least `needed` bytes.
bool rle_segment_is_whole(std::span<const std::byte> packed, std::uint64_t needed) {
  std::uint64_t unpacked = 0;
  for (std::size_t at = 0; at < packed.size() && unpacked < needed;) {
    const auto code = static_cast<std::int8_t>(packed[at++]);
    if (code == -128) continue;
    const std::size_t taken = code >= 0 ? static_cast<std::size_t>(code) + 1 : 1;
    if (at + taken > packed.size()) return false;
    unpacked += code >= 0 ? taken : static_cast<std::size_t>(1 - code);
    at += taken;
  }
  return unpacked >= needed;
}

bool rle_frame_is_whole(const InputFile& file, const Fragment& fragment,
                        const DicomPixels& pixels) {
  constexpr std::size_t kHeadBytes = 64;
  if (fragment.length < kHeadBytes) return false;
  std::string bytes(fragment.length, '\0');
  file.read(fragment.offset, std::as_writable_bytes(std::span(bytes)));
  const HeaderBytes head(bytes.substr(0, kHeadBytes), Endian::kLittle);
  const auto segments = head.at<std::uint32_t>(0);
  if (segments == 0 || segments > 15) return false;
  const std::uint64_t needed = pixels.frame_samples * pixels.bits / 8 / segments;
  for (std::size_t i = 0; i < segments; ++i) {
    const std::uint64_t begin = head.at<std::uint32_t>(4 + 4 * i);
    const std::uint64_t end =
        i + 1 < segments ? head.at<std::uint32_t>(8 + 4 * i) : fragment.length;
    if (begin > end || end > fragment.length) return false;
    const auto packed = std::as_bytes(std::span(bytes)).subspan(begin, end - begin);
    if (!rle_segment_is_whole(packed, needed)) return false;
  }
  return true;
}

void check_fragments(const InputFile& file, const DicomPixels& pixels) {
  const std::vector<Fragment> fragments = fragments_at(file, pixels.offset);
  if (fragments.size() < pixels.frames) {
    fail_damaged(file.path(), "it has " + std::to_string(fragments.size()) +
                                  " compressed frames of " + std::to_string(pixels.frames));
  }
  const bool is_rle = pixels.syntax == kRleSyntax;
  constexpr std::string_view kJpegs = "1.2.840.10008.1.2.4.";
  const bool is_jpeg =
      pixels.syntax.starts_with(kJpegs) && pixels.syntax.size() == kJpegs.size() + 2;
  const bool one_each = fragments.size() == pixels.frames;
  for (std::size_t i = one_each ? 0 : fragments.size() - 1; i < fragments.size(); ++i) {
    const bool is_whole = is_jpeg              ? ends_as_jpeg(file, fragments[i])
                          : is_rle && one_each ? rle_frame_is_whole(file, fragments[i], pixels)
                                               : true;
    if (!is_whole) fail_damaged(file.path(), "a compressed frame ends too early");
  }
}

}  // namespace

bool has_pixels_before(const InputFile& file, std::uint64_t offset, std::uint16_t element) {
  std::string before(12, '\0');
  if (offset < before.size() || offset > file.size()) return false;
  file.read(offset - before.size(), std::as_writable_bytes(std::span(before)));
  // Group and element are four bytes before the length, or eight if the type is in between.
  const auto is_tag = [&](const HeaderBytes& bytes, std::size_t at) {
    return bytes.at<std::uint16_t>(at) == 0x7FE0 && bytes.at<std::uint16_t>(at + 2) == element;
  };
  for (const Endian endian : {Endian::kLittle, Endian::kBig}) {
    const HeaderBytes bytes(before, endian);
    if (is_tag(bytes, 0) || is_tag(bytes, 4)) return true;
  }
  return false;
}

bool check_dicom_pixels(const InputFile& file, const DicomPixels& pixels) {
  if (!has_pixels_before(file, pixels.offset, pixels.element)) {
    fail_reading(file.path(), "it has no pixel data, or ends before them",
                 "Get a complete copy of the file, or leave it out");
  }
  std::string before(12, '\0');
  file.read(pixels.offset - before.size(), std::as_writable_bytes(std::span(before)));
  const Endian endian = pixels.syntax == kBigEndianSyntax ? Endian::kBig : Endian::kLittle;
  const HeaderBytes bytes(before, endian);
  const auto length = bytes.at<std::uint32_t>(8);
  const bool is_native = pixels.syntax == "1.2.840.10008.1.2" ||
                         pixels.syntax == "1.2.840.10008.1.2.1" ||
                         pixels.syntax == kBigEndianSyntax;
  if (length == kUndefinedLength && is_native) {
    fail_reading(file.path(),
                 "its pixels are in fragments, but its transfer syntax is uncompressed",
                 "Save it again, by the program it is from");
  }
  if (length == kUndefinedLength) {
    check_fragments(file, pixels);
    return false;
  }
  const std::uint64_t needed = (pixels.frames * pixels.frame_samples * pixels.bits + 7) / 8;
  const std::uint64_t found = file.size() - std::min(pixels.offset, file.size());
  const std::uint64_t there = std::min<std::uint64_t>(length, found);
  if (there < needed || found < length) {
    const std::string problem =
        std::to_string(there) +
        " bytes are present, but its rows, columns, frames and bits require " +
        std::to_string(std::max<std::uint64_t>(needed, length));
    if (found < length) fail_cut_off(file, problem);
    fail_damaged(file.path(), "of its pixel data, " + problem);
  }
  return length > needed + needed % 2;
}

}  // namespace multitetra

#include "server/volume/formats/dicom/detail/dicom_meta.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>

#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/dicom/dicom_series.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kPreambleBytes = 132;
constexpr std::size_t kHeadBytes = 12;  // At most.
constexpr std::uint32_t kUndefinedLength = 0xFFFFFFFF;
constexpr std::uint16_t kMarks = 0xFFFE;  // Group of the marks of items and sequences.
constexpr std::string_view kBigEndianSyntax = "1.2.840.10008.1.2.2";

bool has_preamble(std::string_view beginning) {
  return beginning.size() >= kPreambleBytes && beginning.substr(128, 4) == "DICM";
}

// The part of a data element before its value (DICOM PS3.5, section 7.1).
struct ElementHead {
  std::uint16_t group = 0;
  std::uint16_t element = 0;
  bool has_type = false;
  std::size_t bytes = 8;
  std::uint32_t length = 0;  // Of the value.
};

// Parses the 12 bytes with which an element begins, with a type (value representation) or without.
ElementHead head_from(std::string bytes, Endian endian) {
  constexpr std::string_view kShort = "AE AS CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US";
  const std::string type = bytes.substr(4, 2);
  const HeaderBytes numbers(std::move(bytes), endian);
  ElementHead head{.group = numbers.at<std::uint16_t>(0), .element = numbers.at<std::uint16_t>(2)};
  head.has_type = head.group != kMarks &&
                  type.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") == std::string::npos;
  if (!head.has_type) {
    head.length = numbers.at<std::uint32_t>(4);
  } else if (kShort.find(type) != std::string_view::npos) {
    head.length = numbers.at<std::uint16_t>(6);
  } else {
    head.bytes = kHeadBytes;
    head.length = numbers.at<std::uint32_t>(8);
  }
  return head;
}

// An element at the beginning of a file.
struct FirstElement {
  ElementHead head;
  std::size_t end = 0;  // Offset behind its value.
};

// Parses a little-endian element of group 2 or 8.
std::optional<FirstElement> element_at(std::string_view bytes, std::size_t at) {
  if (at + kHeadBytes > bytes.size()) return std::nullopt;
  const ElementHead head = head_from(std::string(bytes.substr(at, kHeadBytes)), Endian::kLittle);
  const std::size_t end = at + head.bytes + head.length;
  const bool is_valid =
      (head.group == 2 || head.group == 8) && head.length % 2 == 0 && end - at < 0x10000;
  return is_valid ? std::optional(FirstElement{head, end}) : std::nullopt;
}

// Returns whether the first two elements are valid, in order, and of the groups that come first.
bool begins_with_elements(std::string_view bytes) {
  const std::optional<FirstElement> first = element_at(bytes, 0);
  const std::optional<FirstElement> second = first ? element_at(bytes, first->end) : std::nullopt;
  return second && std::tie(first->head.group, first->head.element) <
                       std::tie(second->head.group, second->head.element);
}

[[noreturn]] void fail_cut_off(const InputFile& file) {
  fail_incomplete(file.path(), "it ends within its header");
}

// Returns the head of an element, or nothing at the end of the file.
std::optional<ElementHead> read_head(const InputFile& file, std::uint64_t at, Endian endian) {
  std::string bytes(kHeadBytes, '\0');
  const std::size_t got = file.read_some(at, std::as_writable_bytes(std::span(bytes)));
  if (got == 0) return std::nullopt;
  const ElementHead head = head_from(std::move(bytes), endian);
  if (got < head.bytes) fail_cut_off(file);
  return head;
}

}  // namespace

bool is_dicom(std::string_view beginning) {
  return has_preamble(beginning) || begins_with_elements(beginning);
}

std::uint64_t dicom_meta_end(const InputFile& file) {
  constexpr std::size_t kMostMetaBytes = 1 << 17;
  const std::string beginning = file.beginning(kMostMetaBytes);
  std::size_t end = has_preamble(beginning) ? kPreambleBytes : 0;
  for (std::optional<FirstElement> element = element_at(beginning, end);
       element && element->head.group == 2; element = element_at(beginning, end)) {
    end = element->end;
  }
  if (end + kHeadBytes > file.size()) fail_cut_off(file);
  return end;
}

void check_dicom_elements(const InputFile& file, std::uint64_t meta_end) {
  constexpr std::uint32_t kPixels = 0x7FE0'0000;
  constexpr std::uint32_t kItem = 0xFFFE'E000;
  constexpr std::uint32_t kSequenceEnd = 0xFFFE'E0DD;
  const bool is_big = file.beginning(meta_end).find(kBigEndianSyntax) != std::string::npos;
  const Endian endian = is_big ? Endian::kBig : Endian::kLittle;
  std::optional<ElementHead> head = read_head(file, meta_end, endian);
  const bool has_types = head && head->has_type;
  int depth = 0;               // Of sequences that end with a mark.
  std::uint32_t previous = 0;  // Of those that are in none.
  for (std::uint64_t at = meta_end; head; head = read_head(file, at, endian)) {
    const std::uint32_t tag = std::uint32_t{head->group} << 16 | head->element;
    const bool is_mark = head->group == kMarks;
    if (is_mark ? depth == 0 : head->has_type != has_types) return;
    if (depth == 0 && (tag >= kPixels || tag <= previous)) return;
    if (depth == 0) previous = tag;
    at += head->bytes;
    if (head->length == kUndefinedLength) {
      if (tag != kItem) ++depth;
    } else if (tag == kSequenceEnd) {
      --depth;
    } else {
      at += head->length;
      if (at > file.size()) fail_cut_off(file);
    }
  }
}

}  // namespace multitetra

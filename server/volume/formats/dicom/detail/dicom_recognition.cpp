#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/dicom/dicom_series.hpp"

namespace multitetra {
namespace {

// A data element at the beginning of a file without preamble.
struct FirstElement {
  std::uint16_t group = 0;
  std::uint16_t element = 0;
  std::size_t end = 0;  // Offset behind its value.
};

// Parses a little-endian element of group 2 or 8, with a type or without.
std::optional<FirstElement> element_at(std::string_view bytes, std::size_t at) {
  if (at + 12 > bytes.size()) return std::nullopt;
  const HeaderBytes head(std::string(bytes.substr(at, 12)), Endian::kLittle);
  FirstElement element{.group = head.at<std::uint16_t>(0), .element = head.at<std::uint16_t>(2)};
  if (element.group != 2 && element.group != 8) return std::nullopt;
  const std::string_view type = bytes.substr(at + 4, 2);
  const bool has_type = type.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ") == std::string::npos;
  constexpr std::string_view kShort = "AE AS CS DA DS DT IS LO PN SH TM UI UL US";
  if (has_type && kShort.find(type) == std::string_view::npos) {
    element.end = at + 12 + std::size_t{head.at<std::uint32_t>(8)};
  } else if (has_type) {
    element.end = at + 8 + std::size_t{head.at<std::uint16_t>(6)};
  } else {
    element.end = at + 8 + std::size_t{head.at<std::uint32_t>(4)};
  }
  return element.end % 2 == at % 2 && element.end - at < 0x10000 ? std::optional(element)
                                                                 : std::nullopt;
}

// Returns whether the first two elements are valid, in order, and of the groups that come first.
bool begins_with_elements(std::string_view bytes) {
  const std::optional<FirstElement> first = element_at(bytes, 0);
  const std::optional<FirstElement> second = first ? element_at(bytes, first->end) : std::nullopt;
  return second &&
         std::tie(first->group, first->element) < std::tie(second->group, second->element);
}

}  // namespace

bool is_dicom(std::string_view beginning) {
  return (beginning.size() >= 132 && beginning.substr(128, 4) == "DICM") ||
         begins_with_elements(beginning);
}

}  // namespace multitetra

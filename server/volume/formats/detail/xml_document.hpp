// Parses XML documents as trees.
//
//   const auto xml = parse_xml(text);
//   if (const XmlElement* size = xml->child("voxelSize")) ... size->text_of("unit")
//
// Names lose their prefixes ("OME:Pixels" is "Pixels"). Documents that declare entities, whose
// expansion is unbounded, are refused, as are those with more than kMaxXmlElements elements.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

using XmlAttributes = std::map<std::string, std::string, std::less<>>;

struct XmlElement {
  std::string name = {};
  XmlAttributes attributes = {};
  std::string text = {};  // Between its tags, without that of its children, trimmed.
  std::vector<XmlElement> children = {};

  // Returns an attribute; empty if there is none.
  [[nodiscard]] std::string attribute(std::string_view key) const;
  // Returns the first child of this name, or null.
  [[nodiscard]] const XmlElement* child(std::string_view tag) const;
  // Returns the text of the first child of this name; empty if there is none.
  [[nodiscard]] std::string text_of(std::string_view tag) const;
  // Returns all elements of this name below this one, in the order of the document.
  [[nodiscard]] std::vector<const XmlElement*> all(std::string_view tag) const;
};

inline constexpr std::size_t kMaxXmlElements = std::size_t{1} << 19;

// Returns the document's outermost element.
[[nodiscard]] Result<XmlElement> parse_xml(std::string_view text);

}  // namespace multitetra

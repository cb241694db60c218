#include "server/store/detail/bucket_listing.hpp"

#include <algorithm>
#include <map>

namespace multitetra {
namespace {

std::string plain_text(std::string_view xml) {
  static const std::map<std::string_view, char> kEntities = {
      {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string text;
  while (!xml.empty()) {
    const auto entity = std::find_if(kEntities.begin(), kEntities.end(), [&](const auto& known) {
      return xml.starts_with(known.first);
    });
    text += entity == kEntities.end() ? xml.front() : entity->second;
    xml.remove_prefix(entity == kEntities.end() ? 1 : entity->first.size());
  }
  return text;
}

// Returns the texts of all elements of this name. Ignores elements without an end tag.
std::vector<std::string> xml_elements(std::string_view xml, const std::string& name) {
  std::vector<std::string> found;
  const std::string begin = "<" + name + ">";
  const std::string end = "</" + name + ">";
  for (std::size_t at = xml.find(begin); at != std::string_view::npos; at = xml.find(begin)) {
    xml.remove_prefix(at + begin.size());
    const std::size_t length = xml.find(end);
    if (length == std::string_view::npos) break;
    found.push_back(plain_text(xml.substr(0, length)));
    xml.remove_prefix(length + end.size());
  }
  return found;
}

}  // namespace

BucketListing bucket_listing(std::string_view xml) {
  BucketListing listing{.keys = xml_elements(xml, "Key"), .next = {}};
  if (xml_element(xml, "IsTruncated") == "true") {
    listing.next = xml_element(xml, "NextContinuationToken");
  }
  return listing;
}

std::string xml_element(std::string_view xml, const std::string& name) {
  const std::vector<std::string> found = xml_elements(xml, name);
  return found.empty() ? std::string() : found.front();
}

}  // namespace multitetra

// Parses the XML replies of buckets: lists of objects, and single elements. The bytes are
// untrusted.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// A page of a list of objects.
struct BucketListing {
  std::vector<std::string> keys;
  std::string next;  // The token of the next page; empty on the last one.
};

[[nodiscard]] BucketListing bucket_listing(std::string_view xml);

// The text of the first element of this name; empty where there is none.
[[nodiscard]] std::string xml_element(std::string_view xml, const std::string& name);

}  // namespace multitetra

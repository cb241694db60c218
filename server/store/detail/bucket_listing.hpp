// Parses the XML replies of buckets, which are untrusted.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// A page of a listing.
struct BucketListing {
  std::vector<std::string> keys;
  std::string next;  // Continuation token; empty on the last page.
};

[[nodiscard]] BucketListing bucket_listing(std::string_view xml);

// Returns the text of the first element of this name, or nothing.
[[nodiscard]] std::string xml_element(std::string_view xml, const std::string& name);

}  // namespace multitetra

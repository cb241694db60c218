// Replies of stores and their cached data: Content-Range, lists of buckets, and blocks in the disk
// cache. The first byte selects the kind.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include <xxhash.h>

#include "server/store/detail/bucket_listing.hpp"
#include "server/store/detail/content_range.hpp"
#include "server/store/detail/disk_cache.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// An accepted reply has exactly the requested bytes.
void check_range(std::string_view bytes) {
  if (bytes.size() < 8) return;
  std::uint32_t first = 0;
  std::uint32_t length = 0;
  std::memcpy(&first, bytes.data(), 4);
  std::memcpy(&length, bytes.data() + 4, 4);
  if (length == 0) return;
  const auto range = ContentRange::from(bytes.substr(8));
  if (!range) return;
  require(range->first <= range->last);
  const std::uint64_t got = range->last - range->first + 1;
  require(got > 0 && (!range->total || (range->last < *range->total && got <= *range->total)));
  if (range->matches({.first = first, .length = length})) {
    require(range->first == first && got <= length);
  }
  if (range->matches({.first = StoreRange::kFromEnd, .length = length})) {
    require(got <= length && range->last + 1 == range->total);
  }
}

std::string escaped(std::string_view text) {
  std::string xml;
  for (const char c : text) {
    xml += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return xml;
}

// A parsed list can be written and parsed again with the same result.
void check_listing(std::string_view xml) {
  const BucketListing listing = bucket_listing(xml);
  std::string again = "<IsTruncated>true</IsTruncated><NextContinuationToken>" +
                      escaped(listing.next) + "</NextContinuationToken>";
  for (const std::string& key : listing.keys) {
    require(key.size() < xml.size());
    again += "<Key>" + escaped(key) + "</Key>";
  }
  const BucketListing same = bucket_listing(again);
  require(same.keys == listing.keys && same.next == listing.next);
}

// A block that is found matches its checksum.
void check_block(std::string_view bytes) {
  static const TemporaryFolder folder;
  static DiskCache cache(folder.path() / "cache", std::uint64_t{1} << 30);
  folder.file("cache/blocks/file/7", bytes);
  const auto found = cache.find("file", 7);
  const auto* const data = reinterpret_cast<const std::byte*>(bytes.data());
  if (found) {
    require(found->size() + sizeof(std::uint64_t) == bytes.size());
    require(std::equal(found->begin(), found->end(), data));
    std::uint64_t sum = 0;
    std::memcpy(&sum, bytes.data() + found->size(), sizeof sum);
    require(XXH3_64bits(found->data(), found->size()) == sum);
  }
  cache.put("file", 8, std::span(data, bytes.size()));
  const auto kept = cache.find("file", 8);
  require(kept && kept->size() == bytes.size() && std::equal(kept->begin(), kept->end(), data));
}

}  // namespace
}  // namespace multitetra

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      check_range(bytes);
      break;
    case 1:
      check_listing(bytes);
      break;
    case 2:
      check_block(bytes);
      break;
    default:
      break;
  }
  return 0;
}

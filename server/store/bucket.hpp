// Operations on a bucket (s3://bucket/...) besides reading: listing objects and uploading a file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/http_options.hpp"

namespace multitetra {

// Whether a place below which files lie is meant: s3://bucket, s3://bucket/prefix/ and whatever
// does not end in `suffix`.
[[nodiscard]] bool is_bucket_folder(std::string_view place, std::string_view suffix);

// What a listing may take. A page of S3 has at most 1000 objects.
struct ListingLimits {
  std::size_t pages = 10000;
  std::size_t name_bytes = std::size_t{64} << 20;  // Of all names that are returned.
};

// The addresses of the objects directly below an s3:// folder that end in `suffix`, by name. Throws
// StoreError, also when the listing exceeds the limits or when a continuation token repeats, since
// such a listing would never end.
[[nodiscard]] std::vector<std::string> list_bucket(const std::string& folder,
                                                   std::string_view suffix,
                                                   const HttpStoreOptions& options = {},
                                                   const ListingLimits& limits = {});

// An existing object: its ETag and its first `bytes` bytes; nullopt when nothing is. Throws
// StoreError, also for what may not be read: a bucket that may not be listed answers 403 for what
// is missing, and an object that is there must not be taken for missing.
struct StoredObject {
  std::string etag;
  std::vector<std::byte> begin;
};
[[nodiscard]] std::optional<StoredObject> find_object(const std::string& address, std::size_t bytes,
                                                      const HttpStoreOptions& options = {});

// The condition under which an upload replaces an object.
struct UploadCondition {
  enum class Kind { kAnything, kNothing, kThisVersion };
  Kind kind = Kind::kNothing;
  // The ETag for kThisVersion.
  std::string etag = {};
};

// Uploads the file in parts, as one object that appears complete or not at all. A failed upload is
// aborted, so that no parts remain. Throws StoreError, also when the existing object does not meet
// the condition, and std::system_error when the file cannot be read.
void upload_file(const std::filesystem::path& file, const std::string& address,
                 const UploadCondition& condition, const HttpStoreOptions& options = {},
                 const std::function<void(double fraction)>& progress = {});

}  // namespace multitetra

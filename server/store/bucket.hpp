// Lists the objects of a bucket (s3://bucket/...), uploads files to it, downloads and removes them.
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

// Returns whether `place` is a folder of a bucket: s3://bucket, s3://bucket/prefix/, or any s3://
// address that does not end in `suffix`.
[[nodiscard]] bool is_bucket_folder(std::string_view place, std::string_view suffix);

// Limits of a listing. A page of S3 has at most 1000 objects.
struct ListingLimits {
  std::size_t pages = 10000;
  std::size_t name_bytes = std::size_t{64} << 20;  // Total of all returned names.
};

// Returns the addresses of the objects directly below an s3:// folder that end in `suffix`, sorted
// by name. Throws StoreError, also if the listing exceeds the limits or a continuation token
// repeats, since such a listing would never end.
[[nodiscard]] std::vector<std::string> list_bucket(const std::string& folder,
                                                   std::string_view suffix,
                                                   const HttpStoreOptions& options = {},
                                                   const ListingLimits& limits = {});

// The ETag and the first bytes of an object.
struct StoredObject {
  std::string etag;
  std::vector<std::byte> begin;
};
// Returns an object with its first `bytes` bytes; nullopt if it does not exist. Throws StoreError,
// also if access is denied: a bucket that does not permit listing answers 403 for missing objects,
// so an existing object could be mistaken for a missing one.
[[nodiscard]] std::optional<StoredObject> find_object(const std::string& address, std::size_t bytes,
                                                      const HttpStoreOptions& options = {});

// The condition under which an upload may write the object.
struct UploadCondition {
  enum class Kind { kAny, kAbsent, kSameVersion };
  Kind kind = Kind::kAbsent;
  // ETag for kSameVersion.
  std::string etag = {};
};

// Uploads the file in parts as one object, which appears complete or not at all. Aborts a failed
// upload, so that no parts remain. Throws StoreError, also if the existing object does not meet the
// condition, and std::system_error if the file cannot be read.
void upload_file(const std::filesystem::path& file, const std::string& address,
                 const UploadCondition& condition, const HttpStoreOptions& options = {},
                 const std::function<void(double fraction)>& progress = {});

// Writes an object to a file, which appears complete or not at all. Returns false if there is no
// such object. Throws StoreError, also if the object is replaced meanwhile, and std::system_error
// if the file cannot be written.
bool download_file(const std::string& address, const std::filesystem::path& file,
                   const HttpStoreOptions& options = {});

// Removes an object, if there is one. Throws StoreError.
void remove_object(const std::string& address, const HttpStoreOptions& options = {});

}  // namespace multitetra

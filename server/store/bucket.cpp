#include "server/store/bucket.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <set>
#include <system_error>

#include "common/base/atomic_file.hpp"
#include "common/base/percent_encoded.hpp"
#include "server/store/detail/bucket_listing.hpp"
#include "server/store/detail/resolved_url.hpp"
#include "server/store/detail/store_client.hpp"
#include "server/store/store_error.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxAnswerBytes = std::uint64_t{16} << 20;
constexpr std::size_t kMaxTokenBytes = 4096;
// Size of the parts of an upload.
constexpr std::uint64_t kPartBytes = std::uint64_t{16} << 20;
// Maximum number of parts of an upload.
constexpr std::uint64_t kMaxParts = 9999;

std::string text_of(const HttpAnswer& answer) {
  return {reinterpret_cast<const char*>(answer.bytes.data()), answer.bytes.size()};
}

// `action` is "read", "list" and the like.
[[noreturn]] void fail_with(const std::string& address, const HttpAnswer& answer,
                            const char* action) {
  const std::string code = xml_element(text_of(answer), "Code");
  throw StoreError(address,
                   "the bucket returned status " + std::to_string(answer.status) +
                       (code.empty() ? "" : " (" + code + ")"),
                   "Check the address, the network and the credentials", action);
}

[[noreturn]] void fail_listing(const std::string& folder, const std::string& problem) {
  throw StoreError(folder, "its listing has " + problem,
                   "Give a longer prefix, or the addresses of the files");
}

// Rejects a listing that never ends. `token` names the next page, `tokens` name earlier pages.
void check_next_page(const std::string& folder, const std::string& token,
                     const ListingLimits& limits, std::set<std::string>& tokens) {
  if (token.size() > kMaxTokenBytes) {
    fail_listing(folder, "a continuation token of " + std::to_string(token.size()) + " bytes");
  }
  if (!tokens.insert(token).second) fail_listing(folder, "a repeated continuation token");
  if (tokens.size() >= limits.pages) {
    fail_listing(folder, "more than " + std::to_string(limits.pages) + " pages");
  }
}

ResolvedUrl bucket_place(const std::string& address) {
  const ResolvedUrl place = resolved_url(address);
  if (place.is_s3) return place;
  throw StoreError(address, "it is not in a bucket", "Write s3://bucket/path");
}

// A multipart upload in progress. The destructor aborts it unless it is complete.
class Upload {
 public:
  Upload(const std::string& address, const HttpStoreOptions& options)
      : address_(address), place_(bucket_place(address)), client_(true, options) {
    const HttpAnswer answer = send("POST", "uploads=");
    id_ = xml_element(text_of(answer), "UploadId");
    if (!answer.is_good() || id_.empty()) fail_with(address_, answer, "write");
  }
  ~Upload() {
    if (is_complete_) return;
    try {
      (void)send("DELETE", "uploadId=" + percent_encoded(id_));
    } catch (const StoreError&) {  // NOLINT: the bucket removes what is never completed.
    }
  }
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  void add_part(std::span<const std::byte> bytes) {
    const HttpAnswer answer = send(
        "PUT",
        "partNumber=" + std::to_string(etags_.size() + 1) + "&uploadId=" + percent_encoded(id_),
        bytes);
    if (!answer.is_good() || answer.etag.empty()) fail_with(address_, answer, "write");
    etags_.push_back(answer.etag);
  }

  void complete(const UploadCondition& condition) {
    std::string xml = "<CompleteMultipartUpload>";
    for (std::size_t i = 0; i < etags_.size(); ++i) {
      xml += "<Part><PartNumber>" + std::to_string(i + 1) + "</PartNumber><ETag>" + etags_[i] +
             "</ETag></Part>";
    }
    xml += "</CompleteMultipartUpload>";
    std::vector<std::string> headers;
    if (condition.kind == UploadCondition::Kind::kAbsent) headers = {"If-None-Match: *"};
    if (condition.kind == UploadCondition::Kind::kSameVersion) {
      headers = {"If-Match: " + condition.etag};
    }
    const HttpAnswer answer =
        send("POST", "uploadId=" + percent_encoded(id_), std::as_bytes(std::span(xml)), headers);
    // A bucket may detect a failure after it has started a 200 response.
    if (answer.status == 412 || answer.status == 409) {
      throw StoreError(address_, "another file was written to this address in the meantime",
                       "Check that file, then try again", "write");
    }
    if (!answer.is_good() || text_of(answer).find("<Error>") != std::string::npos) {
      fail_with(address_, answer, "write");
    }
    is_complete_ = true;
  }

 private:
  HttpAnswer send(const std::string& method, const std::string& query,
                  std::span<const std::byte> body = {}, std::vector<std::string> headers = {}) {
    return client_.send({.address = place_.address() + "?" + query,
                         .method = method,
                         .headers = std::move(headers),
                         .body = body,
                         .most = kMaxAnswerBytes});
  }

  std::string address_;
  ResolvedUrl place_;
  StoreClient client_;
  std::string id_;
  std::vector<std::string> etags_;
  bool is_complete_ = false;
};

}  // namespace

bool is_bucket_folder(std::string_view place, std::string_view suffix) {
  return place.starts_with("s3://") && !place.ends_with(suffix);
}

std::vector<std::string> list_bucket(const std::string& folder, std::string_view suffix,
                                     const HttpStoreOptions& options, const ListingLimits& limits) {
  const ResolvedUrl place = bucket_place(folder);
  const std::string whole = folder.ends_with('/') ? folder : folder + "/";
  const std::string bucket = whole.substr(0, whole.find('/', 5) + 1);  // "s3://bucket/"
  const std::string prefix = whole.substr(bucket.size());
  StoreClient client(true, options);
  std::vector<std::string> found;
  std::size_t name_bytes = 0;
  std::set<std::string> tokens;
  std::string next;
  do {
    const std::string query =
        (next.empty() ? "" : "continuation-token=" + percent_encoded(next) + "&") +
        std::string("delimiter=%2F&list-type=2&prefix=") + percent_encoded(prefix);
    const HttpAnswer answer =
        client.send({.address = place.origin + "/?" + query, .most = kMaxAnswerBytes});
    if (!answer.is_good()) fail_with(folder, answer, "list");
    const BucketListing listing = bucket_listing(text_of(answer));
    for (const std::string& key : listing.keys) {
      if (!key.ends_with(suffix)) continue;
      name_bytes += bucket.size() + key.size();
      if (name_bytes > limits.name_bytes) {
        fail_listing(folder, "more than " + std::to_string(limits.name_bytes) + " bytes of names");
      }
      found.push_back(bucket + key);
    }
    next = listing.next;
    if (!next.empty()) check_next_page(folder, next, limits, tokens);
  } while (!next.empty());
  std::sort(found.begin(), found.end());
  return found;
}

std::optional<StoredObject> find_object(const std::string& address, std::size_t bytes,
                                        const HttpStoreOptions& options) {
  const ResolvedUrl place = bucket_place(address);
  StoreClient client(true, options);
  HttpAnswer answer = client.send({.address = place.address(),
                                   .range = StoreRange{.first = 0, .length = bytes},
                                   .most = std::max<std::uint64_t>(bytes, kMaxAnswerBytes)});
  if (answer.status == 404) return std::nullopt;
  if (answer.status == 416) return StoredObject{.etag = answer.etag, .begin = {}};  // It is empty.
  if (!answer.is_good()) fail_with(address, answer, "read");
  return StoredObject{.etag = answer.etag, .begin = std::move(answer.bytes)};
}

void upload_file(const fs::path& file, const std::string& address, const UploadCondition& condition,
                 const HttpStoreOptions& options,
                 const std::function<void(double fraction)>& progress) {
  const std::uint64_t size = fs::file_size(file);
  std::ifstream stream(file, std::ios::binary);
  std::vector<std::byte> part;
  Upload upload(address, options);
  if (size == 0) upload.add_part({});
  for (std::uint64_t done = 0; done < size; done += part.size()) {
    part.resize(static_cast<std::size_t>(
        std::min(std::max(kPartBytes, size / kMaxParts + 1), size - done)));
    if (!stream.read(reinterpret_cast<char*>(part.data()),
                     static_cast<std::streamsize>(part.size()))) {
      throw std::system_error(errno, std::generic_category(), "Cannot read " + file.string());
    }
    upload.add_part(part);
    if (progress) progress(static_cast<double>(done + part.size()) / static_cast<double>(size));
  }
  upload.complete(condition);
}

bool download_file(const std::string& address, const fs::path& file,
                   const HttpStoreOptions& options) {
  const ResolvedUrl place = bucket_place(address);
  StoreClient client(true, options);
  AtomicFile into(file);
  std::vector<std::string> same_version;
  std::uint64_t done = 0;
  std::uint64_t size = 0;
  do {
    const HttpAnswer answer = client.send({.address = place.address(),
                                           .range = StoreRange{.first = done, .length = kPartBytes},
                                           .headers = same_version,
                                           .most = kPartBytes});
    if (answer.status == 404) return false;
    if (answer.status == 416 && done == 0) break;  // It is empty.
    if (!answer.is_good() || answer.bytes.empty()) fail_with(address, answer, "read");
    into.write_at(done, answer.bytes);
    done += answer.bytes.size();
    size = answer.total;
    if (!answer.etag.empty()) same_version = {"If-Match: " + answer.etag};
  } while (done < size);
  into.commit(Durability::kProcessEnd);
  return true;
}

void remove_object(const std::string& address, const HttpStoreOptions& options) {
  StoreClient client(true, options);
  const HttpAnswer answer = client.send(
      {.address = bucket_place(address).address(), .method = "DELETE", .most = kMaxAnswerBytes});
  if (!answer.is_good() && answer.status != 404) fail_with(address, answer, "remove");
}

}  // namespace multitetra

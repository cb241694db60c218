// Resolves addresses of objects to a host. For a bucket, the environment gives endpoint and region.
#pragma once

#include <string>

namespace multitetra {

// The URL of an object or a folder.
struct ResolvedUrl {
  bool is_s3 = false;
  std::string origin;  // "https://host:port", plus the bucket if it is part of the path.
  std::string path;    // "/prefix/head.mtd", percent-encoded.

  [[nodiscard]] std::string address() const { return origin + path; }
};

// Throws StoreError for an invalid address, and for a bucket without a name.
[[nodiscard]] ResolvedUrl resolved_url(const std::string& address);

// Returns an environment variable; empty if it is not set.
[[nodiscard]] std::string environment(const char* name);
// Returns AWS_REGION or AWS_DEFAULT_REGION.
[[nodiscard]] std::string aws_region();

}  // namespace multitetra

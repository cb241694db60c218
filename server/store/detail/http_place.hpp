// Where the addresses of objects lead: a host, or a bucket by the environment's endpoint and
// region.
#pragma once

#include <string>

namespace multitetra {

// A place in a bucket, or behind another address, as requests name it.
struct HttpPlace {
  bool is_s3 = false;
  std::string origin;  // "https://host:port", and the bucket where it is part of the path.
  std::string path;    // "/prefix/head.mtd", as in a URL.

  [[nodiscard]] std::string address() const { return origin + path; }
};

// Throws StoreError for what is no address, and for a bucket without a name.
[[nodiscard]] HttpPlace http_place(const std::string& address);

// The variable of the environment; empty where it is not set.
[[nodiscard]] std::string environment(const char* name);
// By AWS_REGION or AWS_DEFAULT_REGION.
[[nodiscard]] std::string aws_region();

}  // namespace multitetra

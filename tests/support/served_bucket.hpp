// A folder as an S3 bucket, to which s3:// addresses lead while it exists, with signed requests.
#pragma once

#include <cstdlib>

#include "tests/support/folder_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {

class ServedBucket {
 public:
  ServedBucket() : server_(folder_.path()) {
    setenv("AWS_ENDPOINT_URL", (server_.address() + "/s3").c_str(), 1);
    setenv("AWS_ACCESS_KEY_ID", "reader", 1);
    setenv("AWS_SECRET_ACCESS_KEY", "a secret", 1);
  }
  ~ServedBucket() {
    for (const char* const name :
         {"AWS_ENDPOINT_URL", "AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN"}) {
      unsetenv(name);
    }
  }
  ServedBucket(const ServedBucket&) = delete;
  ServedBucket& operator=(const ServedBucket&) = delete;

  // Holds "head.mtd" for the object "s3://volumes/head.mtd".
  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
  FolderServer server_;
};

}  // namespace multitetra

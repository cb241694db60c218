// Objects below an address (http://, https://, or s3://bucket/prefix), read by GET requests with
// ranges.
//
// Only the operator's command lines name addresses; requests of clients never do.
#pragma once

#include <memory>
#include <string>

#include "server/store/http_options.hpp"
#include "server/store/object_store.hpp"

namespace multitetra {

// Converts s3:// addresses to https ones of AWS, or of AWS_ENDPOINT_URL if set. Requests to s3://
// are signed with Signature Version 4 if the environment has AWS_ACCESS_KEY_ID and
// AWS_SECRET_ACCESS_KEY (and AWS_SESSION_TOKEN, AWS_REGION, where needed); otherwise the bucket
// must be public. Redirects are followed on the same host, from http to https but not back, and
// with options.follow to other hosts, which never receive credentials: neither S3 keys nor the
// address's user and password. 401 and 403 throw StoreAccessDenied, since they do not reveal
// whether the object exists. Throws StoreError for an invalid address.
[[nodiscard]] std::unique_ptr<ObjectStore> http_store(const std::string& address,
                                                      const HttpStoreOptions& options = {});

}  // namespace multitetra

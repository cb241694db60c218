// Objects below an address: http://, https://, or s3://bucket/prefix, read by plain GET with
// ranges.
//
// Only the operator's own command lines name addresses; no request of a client ever does.
#pragma once

#include <memory>
#include <string>

#include "server/store/http_options.hpp"
#include "server/store/object_store.hpp"

namespace multitetra {

// s3:// addresses become https ones of AWS, or of AWS_ENDPOINT_URL where that is set. With
// AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in the environment (and AWS_SESSION_TOKEN,
// AWS_REGION, where needed) requests to s3:// are signed with Signature Version 4; without them the
// bucket must be public. Redirects are followed to the same host, from http to https but not back,
// and with options.follow to other hosts, which never get credentials: neither those of S3 nor a
// user and password of the address. 401 and 403 are StoreAccessDenied, for they say nothing of
// whether there is an object. Throws StoreError for an address that is none.
[[nodiscard]] std::unique_ptr<ObjectStore> http_store(const std::string& address,
                                                      const HttpStoreOptions& options = {});

}  // namespace multitetra

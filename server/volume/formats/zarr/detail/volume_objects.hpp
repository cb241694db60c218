// A store with a volume's objects, whose failures are reported as VolumeFileError.
#pragma once

#include <memory>
#include <string>

#include "server/store/object_store.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The store denies access to an object, which may or may not exist.
class InaccessibleObject : public VolumeFileError {
 public:
  using VolumeFileError::VolumeFileError;
};

// Opens the files below a folder, in a zip archive, or below an address (http_store.hpp). Links,
// keys and redirects that lead elsewhere require `allow_external_files`. This function and the
// store's throw VolumeFileError instead of StoreError, and InaccessibleObject instead of
// StoreAccessDenied.
[[nodiscard]] std::shared_ptr<ObjectStore> volume_objects(const std::string& place,
                                                          bool allow_external_files);

}  // namespace multitetra

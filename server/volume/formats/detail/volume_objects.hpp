// The objects of a volume: a store whose failures are reported as those of a volume file.
#pragma once

#include <memory>
#include <string>

#include "server/store/object_store.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// An object that the store refuses: whether it is there is not known.
class InaccessibleObject : public VolumeFileError {
 public:
  using VolumeFileError::VolumeFileError;
};

// The files below a folder, those in a zip archive, or what lies below an address (http_store.hpp).
// Links, keys and redirects that lead elsewhere are followed only with `follow`. Throws
// VolumeFileError, now and from the store's functions, where the store throws StoreError;
// InaccessibleObject for StoreAccessDenied.
[[nodiscard]] std::shared_ptr<ObjectStore> volume_objects(const std::string& place, bool follow);

}  // namespace multitetra

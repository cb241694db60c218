// The objects that a volume is made of: a store whose trouble is told as that of a volume file.
#pragma once

#include <memory>
#include <string>

#include "server/store/object_store.hpp"

namespace multitetra {

// The files below a folder, or what lies below an address (http_store.hpp). Throws VolumeFileError,
// now and from the store's functions, where the store throws StoreError.
[[nodiscard]] std::shared_ptr<ObjectStore> volume_objects(const std::string& place);

}  // namespace multitetra

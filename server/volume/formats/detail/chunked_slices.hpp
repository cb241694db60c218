// The slices of a volume inside a chunked array.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/store/object_store.hpp"
#include "server/volume/formats/detail/chunked_array.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The dimensions of the array that are the volume's axes x, y and z (z may be none: one slice), and
// where it lies along the others.
struct VolumeInArray {
  std::array<std::optional<std::size_t>, 3> axes;
  std::vector<std::int64_t> at;  // For every dimension; those of the axes are not looked at.
};

// `path` is the array's own key prefix in the store, empty or ending in '/'. Chunks are fetched and
// unpacked in parallel. A layer of them is kept, so that slices read in order fetch each chunk once
// (of layers larger than 1 GiB only the requested part). A missing chunk holds the fill value; the
// findings count them. Chunks and indices of shards in work take half a GiB, or those of one chunk.
[[nodiscard]] std::unique_ptr<StoredSlices> chunked_slices(std::shared_ptr<ObjectStore> store,
                                                           std::string path, ArrayLayout layout,
                                                           VolumeInArray volume);

}  // namespace multitetra

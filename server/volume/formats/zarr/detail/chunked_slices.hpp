// The slices of a volume within a chunked array.
#pragma once

#include <memory>
#include <string>

#include "server/store/object_store.hpp"
#include "server/volume/formats/arrays/array_volume.hpp"
#include "server/volume/formats/zarr/detail/chunked_array.hpp"

namespace multitetra {

// `path` is the array's key prefix in the store, empty or ending with '/'. Fetches and unpacks
// chunks in parallel. Keeps a layer of chunks, so that reading slices in order fetches each chunk
// once (for layers larger than 1 GiB, keeps only the requested part). Missing chunks have the fill
// value; the findings count them. Chunks and shard indices in progress take at most 512 MiB, or as
// much as one chunk needs.
[[nodiscard]] std::unique_ptr<StoredSlices> chunked_slices(std::shared_ptr<ObjectStore> store,
                                                           std::string path, ArrayLayout layout,
                                                           VolumeInArray volume);

}  // namespace multitetra

// A prepared dataset that is made of objects, opened: from a folder, or from a store far away.
//
//   const auto cache = std::make_shared<ObjectCache>(ObjectCacheOptions{});
//   const DatasetPtr head = open_objects("https://store.example/volumes/head", cache);
//
// Opening fetches the manifest and one object more (a few, where the volume is large). What is
// looked at later is fetched then, object by object; whoever knows what that will be tells the
// source of bricks (will_need). Bytes are what their names say, and bricks have their checksums.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/dataset/dataset.hpp"
#include "server/dataset/objects/object_cache.hpp"

namespace multitetra {

// Whether a dataset made of objects is meant: an address, or a folder with a manifest.
[[nodiscard]] bool is_object_dataset(const std::string& place);

// Whether a folder of datasets is meant, which is none itself.
[[nodiscard]] bool is_folder_of_datasets(const std::string& place);

// The files *.mtd and the folders of objects in a folder, by name. Throws
// std::filesystem::filesystem_error when it cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> datasets_in(const std::filesystem::path& folder);

// Throws StoreError when the store fails, DatasetFileError when what it has is no whole dataset;
// later, whoever reads a brick gets these out of it.
[[nodiscard]] DatasetPtr open_objects(const std::string& place, std::shared_ptr<ObjectCache> cache);

// A file, or a dataset made of objects; with a small cache of its own where none is given.
[[nodiscard]] DatasetPtr open_any_dataset(const std::string& place,
                                          std::shared_ptr<ObjectCache> cache = nullptr);

}  // namespace multitetra

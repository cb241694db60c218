// From the single file to a folder of objects, and back: the same dataset, bit for bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "server/dataset/objects/object_cache.hpp"
#include "server/dataset/verify_dataset.hpp"

namespace multitetra {

struct ConvertedObjects {
  std::size_t objects = 0;          // That the dataset has,
  std::uint64_t bytes = 0;          // with so many bytes.
  std::uint64_t new_bytes = 0;      // Of objects that were not there before.
  std::uint64_t removed_bytes = 0;  // Of objects of other versions.
};

// Takes a file, whose every byte is verified on the way, into the folder. Objects that are there
// already stay as they are; with `remove_others` those go that this version does not have. Needs
// memory for an object and the indexes. Throws DatasetFileError.
ConvertedObjects file_to_objects(const std::filesystem::path& file,
                                 const std::filesystem::path& folder, bool remove_others,
                                 const VerificationProgress& progress = {});

// The same for a dataset that shares its objects: `folder` is one of those in the store, and its
// objects go into the store's. What is equal among datasets, such as what stays the same from one
// time of a series to the next, is there once.
ConvertedObjects file_to_shared_objects(const std::filesystem::path& file,
                                        const std::filesystem::path& folder,
                                        const VerificationProgress& progress = {});

// Removes the objects of a store that none of its datasets has. Returns how many bytes they had.
// Throws StoreError, DatasetFileError: then nothing is removed.
std::uint64_t remove_unused_objects(const std::filesystem::path& store);

// Makes the file that the dataset at `place` came from. It appears whole and verified, or not at
// all. Throws StoreError, DatasetFileError.
void objects_to_file(const std::string& place, const std::shared_ptr<ObjectCache>& cache,
                     const std::filesystem::path& file, const VerificationProgress& progress = {});

// Reads every object, once, and verifies it: its name, the checksums of its bricks and sections,
// and that the range and the number of void samples in the metadata are those of the samples.
// Throws StoreError, DatasetFileError.
struct VerifiedObjects {
  std::size_t objects = 0;
  std::uint64_t bytes = 0;
};
VerifiedObjects verify_objects(const std::string& place, const std::shared_ptr<ObjectCache>& cache,
                               const VerificationProgress& progress = {});

}  // namespace multitetra

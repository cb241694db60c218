// Prepares a dataset in parts: on any machine, in any order, each as often as needed; then merges
// them.
//
//   write_plan("head.mtd", {.metadata = ..., .bins = ..., .parts = 8});   // From a survey.
//   prepare_part(*source, "head.mtd", 3);                                 // For each part, 0 to 7.
//   merge_parts("head.mtd");                                              // Now it can be served.
//
// Plan and parts lie in "head.mtd.parts", a folder that all machines share, or into which the files
// of the parts are copied before the merge.
//
// Guaranteed: the result is bit for bit the file of one process, for any number of parts. A part
// appears complete or not at all, and preparing it again gives the same bytes. A merge copies the
// packed samples without unpacking them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "server/dataset/prepare.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

struct PartOptions {
  // Bounds of memory; the result is the same for any.
  std::size_t slab_bytes = std::size_t{64} << 20;
  std::size_t column_bytes = kMostColumnBytes;
  // Progress: the current stage, and how much of it is done.
  std::function<void(const char* pass, std::uint64_t done, std::uint64_t all)> progress = nullptr;
};

// Makes part `part` (from 0 on) of the plan of `dataset`, out of the volume that was planned.
// Throws std::invalid_argument when there is no such part, VolumeFileError when the source fails or
// is another volume, DatasetFileError when the plan or the disk is not as it should be.
void prepare_part(VolumeSource& source, const std::filesystem::path& dataset, std::size_t part,
                  const PartOptions& options = {});

// The missing parts of the plan, counted from 0. Throws DatasetFileError.
[[nodiscard]] std::vector<std::size_t> missing_parts(const std::filesystem::path& dataset);

// Makes the dataset and removes what the parts left. Throws DatasetFileError when parts are missing
// or damaged: then nothing has changed.
DatasetInfo merge_parts(const std::filesystem::path& dataset, const PartOptions& options = {});

}  // namespace multitetra

// Prepares a dataset in parts, on any machine, in any order, each as often as needed; then merges
// them.
//
//   write_plan("head.mtd", {.metadata = ..., .bins = ..., .parts = 8});   // From a survey.
//   prepare_part(*source, "head.mtd", 3);                                 // For each part, 0 to 7.
//   merge_parts("head.mtd");                                              // Now it can be served.
//
// The plan and the parts are stored in the folder "head.mtd.parts", which all machines share or
// into which the parts are copied before the merge. All functions also accept a dataset in a bucket
// (s3://volumes/head.mtd): parts are made and merged in a temporary folder, so the merge needs
// the disk space of all of them. They throw StoreError if the bucket fails.
//
// Guaranteed: the result is bit for bit the file that a single process writes, for any number of
// parts. A part appears complete or not at all, and preparing it again gives the same bytes. A
// merge copies the packed samples without unpacking them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "server/dataset/prepare.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

struct PartOptions {
  // Bound the memory; they do not affect the result.
  std::size_t slab_bytes = std::size_t{64} << 20;
  std::size_t column_bytes = kMaxColumnBytes;
  // Called with the current stage and its progress.
  std::function<void(const char* pass, std::uint64_t done, std::uint64_t all)> progress = nullptr;
};

// Prepares part `part` (from 0) of the plan of `dataset` from the planned volume. Throws
// std::invalid_argument if there is no such part, VolumeFileError if the source fails or is a
// different volume, DatasetFileError if the plan is missing or damaged or the disk fails.
void prepare_part(VolumeSource& source, const std::filesystem::path& dataset, std::size_t part,
                  const PartOptions& options = {});

struct MergedDataset {
  DatasetInfo info;
  std::uint64_t file_bytes = 0;
};
// Writes the dataset and removes the files of the parts. Throws DatasetFileError, changing nothing,
// if parts are missing or damaged.
MergedDataset merge_parts(const std::filesystem::path& dataset, const PartOptions& options = {});

}  // namespace multitetra

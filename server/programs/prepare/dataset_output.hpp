// The output of `prepare`: a file, or into a bucket (s3://bucket/head.mtd), through a
// file in the temporary folder.
//
//   DatasetOutput output("s3://volumes/head.mtd", force);
//   ... output.file() is written ...
//   output.finish();
#pragma once

#include <filesystem>
#include <functional>

#include "server/store/bucket.hpp"

namespace multitetra {

class DatasetOutput {
 public:
  // Throws ExitError unless a dataset may take this name: without `force` only an older dataset is
  // replaced, and the name ends in .mtd. Throws StoreError when a bucket cannot be read.
  DatasetOutput(const std::filesystem::path& output, bool force);
  ~DatasetOutput();
  DatasetOutput(const DatasetOutput&) = delete;
  DatasetOutput& operator=(const DatasetOutput&) = delete;

  // What is to be written.
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

  // Puts the file into its bucket, where it goes to one. It appears whole or not at all, and only
  // over what was there in the beginning. Throws StoreError.
  void finish(const std::function<void(double fraction)>& progress = {});

 private:
  std::filesystem::path output_;
  std::filesystem::path file_;
  std::filesystem::path temporary_;  // A folder; empty where none is needed.
  UploadCondition condition_;
};

// A folder of this machine for what waits while datasets are made that go to `output`.
[[nodiscard]] std::filesystem::path scratch_folder(const std::filesystem::path& output);

}  // namespace multitetra

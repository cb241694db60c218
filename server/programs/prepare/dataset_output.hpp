// The output of `prepare`: a file, or an object in a bucket (s3://bucket/head.mtd), uploaded from a
// temporary file.
//
//   DatasetOutput output("s3://volumes/head.mtd", force);
//   ... write output.file() ...
//   output.finish();
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "common/base/scratch_file.hpp"
#include "server/store/bucket.hpp"

namespace multitetra {

class DatasetOutput {
 public:
  // Throws ExitError unless the name ends in .mtd and, without `force`, is unused or belongs to an
  // older dataset. Throws StoreError if a bucket cannot be read.
  DatasetOutput(const std::filesystem::path& output, bool force);

  // The file to write.
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

  // Uploads the file if the output is in a bucket. The upload is atomic, and replaces only the
  // object found by the constructor. Throws StoreError.
  void finish(const std::function<void(double fraction)>& progress = {});

 private:
  std::filesystem::path output_;
  std::filesystem::path file_;
  std::optional<ScratchFolder> temporary_;  // For outputs in a bucket.
  UploadCondition condition_;
};

// Returns a local folder for temporary files of datasets for `output`.
[[nodiscard]] std::filesystem::path scratch_folder(const std::filesystem::path& output);

}  // namespace multitetra

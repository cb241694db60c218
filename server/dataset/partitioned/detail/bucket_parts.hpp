// The plan and the parts of a dataset in a bucket: objects named like the files of part_files.hpp
// below "s3://bucket/big.mtd.parts/". Parts are made and merged in a temporary folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "common/base/scratch_file.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {

// All functions throw StoreError if the bucket fails, std::system_error if the disk does.
class BucketParts {
 public:
  // Requires an address of a bucket.
  explicit BucketParts(const std::filesystem::path& dataset);

  // Runs an action on the dataset's file in the temporary folder, beside which its parts are. A
  // DatasetFileError then names the objects of the bucket.
  template <typename Action>
  auto run(const Action& action) const {
    try {
      return action(file_);
    } catch (const DatasetFileError& error) {
      throw DatasetFileError(with_addresses(error.what()));
    }
  }

  // Downloads the plan. Throws DatasetFileError, with a remedy, if there is none.
  void fetch_plan() const;
  // Downloads all parts that are there.
  void fetch_parts() const;
  void send_plan() const;
  // Uploads a part. Its record is the last, so that it counts as prepared only then.
  void send_part(std::size_t part) const;
  // Uploads the merged dataset unless another file was written to its address in the meantime;
  // then removes the plan and the parts.
  void finish() const;

 private:
  void send(const std::filesystem::path& file) const;
  [[nodiscard]] std::string with_addresses(std::string text) const;

  std::string dataset_;  // Its address.
  ScratchFolder folder_;
  std::filesystem::path file_;
};

}  // namespace multitetra

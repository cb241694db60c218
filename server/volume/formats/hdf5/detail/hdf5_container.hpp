// An HDF5 file as a container of arrays, and its datasets as arrays whose chunks are checked.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/volume/formats/arrays/array_volume.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"

namespace multitetra {

class Hdf5Container : public ArrayContainer {
 public:
  // Requires that `file` remains open. Links to other files are followed as by open_hdf5_object().
  Hdf5Container(std::filesystem::path path, hid_t file, bool allow_external_files)
      : path_(std::move(path)), file_(file), allow_external_files_(allow_external_files) {}

  [[nodiscard]] std::filesystem::path file() const override { return path_; }
  [[nodiscard]] std::vector<std::string> arrays() const override;
  [[nodiscard]] std::vector<std::string> children(const std::string& group) const override;
  [[nodiscard]] std::vector<std::int64_t> shape(const std::string& array) const override;
  [[nodiscard]] std::optional<StoredType> type(const std::string& array) const override;
  [[nodiscard]] std::vector<double> values(const std::string& array) const override;
  [[nodiscard]] std::vector<double> numbers(const std::string& object,
                                            const char* attribute) const override;
  [[nodiscard]] std::vector<std::string> texts(const std::string& object,
                                               const char* attribute) const override;
  [[nodiscard]] std::vector<std::string> dimension_names(const std::string& array) const override;
  [[nodiscard]] std::string coordinates(const std::string& array,
                                        std::size_t dimension) const override;

 private:
  [[nodiscard]] Hdf5Id object(const std::string& path) const;
  [[nodiscard]] Hdf5Id dataset(const std::string& path) const;

  std::filesystem::path path_;
  hid_t file_;
  bool allow_external_files_;
  mutable std::vector<std::string> arrays_;  // Of arrays(), once they are found.
  mutable bool is_searched_ = false;
};

// Reads boxes of a dataset of `file`, whose chunks it checks first. Throws VolumeFileError if there
// is no such dataset.
[[nodiscard]] std::unique_ptr<ArrayReader> hdf5_reader(const std::filesystem::path& path,
                                                       Hdf5Id file, const std::string& dataset,
                                                       bool allow_external_files);

// Returns a notice that samples of a dataset were never written, so that they have its fill value,
// empty if all were.
[[nodiscard]] std::string unwritten_notice(const std::filesystem::path& path, hid_t file,
                                           const std::string& dataset, bool allow_external_files);

}  // namespace multitetra

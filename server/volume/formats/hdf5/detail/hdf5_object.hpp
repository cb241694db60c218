// Helpers of the HDF5 reader: identifiers, attributes, and references to other files. Only the
// hdf5_ files include libhdf5.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Owns an identifier of libhdf5 and closes it.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Id(hid_t id, Close close) : id_(id), close_(close) {}
  ~Hdf5Id() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  [[nodiscard]] explicit operator bool() const { return id_ >= 0; }
  [[nodiscard]] hid_t get() const { return id_; }

 private:
  hid_t id_;
  Close close_;
};

// Samples of a dataset: the first one's indices, and the counts along each dimension.
struct Hdf5Box {
  std::vector<hsize_t> start;
  std::vector<hsize_t> extent;
};
[[nodiscard]] Hdf5Box whole_box(std::vector<hsize_t> dims);

// A part of a virtual dataset and its source. The boxes bound the samples.
struct Hdf5Mapping {
  std::filesystem::path file;
  std::string dataset;
  Hdf5Box in_virtual;
  Hdf5Box in_source;  // Empty: unknown.
};

// Returns the dimensions of a dataset; none without a simple extent.
[[nodiscard]] std::vector<hsize_t> hdf5_dims(hid_t dataset);

// Returns the bytes of all samples; the largest number if they do not fit in one.
[[nodiscard]] hsize_t hdf5_bytes(hid_t dataset);

// Returns up to `most` numbers of an attribute; none if it is missing or not numeric.
[[nodiscard]] std::vector<double> hdf5_numbers(hid_t object, const char* attribute,
                                               std::size_t most);

// Returns the texts of an attribute with one or several; none if it is missing.
[[nodiscard]] std::vector<std::string> hdf5_texts(hid_t object, const char* attribute);

// Opens a group or a dataset of `file`, also through links that open_hdf5_dataset() would follow.
// Invalid if there is none, or a link is not permitted.
[[nodiscard]] Hdf5Id open_hdf5_object(const std::filesystem::path& file, hid_t in,
                                      const std::string& name, bool allow_external_files);

// Opens a file for reading, without locks. Throws VolumeFileError with the reason from libhdf5.
[[nodiscard]] Hdf5Id open_hdf5_file(const std::filesystem::path& file);

// Opens a dataset of `file`. Other files that it reads (external links, external storage, sources
// of virtual datasets) must exist, be complete, and be regular files in the same folder, or
// anywhere with `allow_external_files`. Returns nullopt if there is no such dataset. Throws
// VolumeFileError.
[[nodiscard]] std::optional<Hdf5Id> open_hdf5_dataset(const std::filesystem::path& file, hid_t in,
                                                      const std::string& name,
                                                      bool allow_external_files);

// Returns the mappings of a virtual dataset, with one for each existing file of a numbered source.
// Throws VolumeFileError if there are too many, the datasets are numbered ("%b"), or a file is
// missing or not allowed.
[[nodiscard]] std::vector<Hdf5Mapping> hdf5_mappings(const std::filesystem::path& file,
                                                     hid_t dataset, bool allow_external_files);

}  // namespace multitetra

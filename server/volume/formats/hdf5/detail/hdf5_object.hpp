// Shared by the readers of HDF5 files: identifiers that close themselves, attributes, and what a
// file refers to outside of itself. libhdf5 is seen in the hdf5_ and imaris_ files alone.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Owns an identifier of the library.
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

// Empty where it has none, or no simple extent.
[[nodiscard]] std::vector<hsize_t> hdf5_dims(hid_t dataset);

// Up to `most` numbers of an attribute; none when it is missing or no numbers.
[[nodiscard]] std::vector<double> hdf5_numbers(hid_t object, const char* attribute,
                                               std::size_t most);

// A text attribute, also one of an array of characters, as Imaris has it; empty: none.
[[nodiscard]] std::string hdf5_text(hid_t object, const char* attribute);

// Opens a file for reading, without locks. Throws VolumeFileError with what libhdf5 has against it.
[[nodiscard]] Hdf5Id open_hdf5_file(const std::filesystem::path& file);

// Opens a dataset of `file`. Whatever it reads outside of that file (external links, external
// storage, the sources of virtual datasets) must be a regular file in the same folder, or anywhere
// with `follow`, and must be there with all that is needed. nullopt when there is no such dataset.
// Throws VolumeFileError.
[[nodiscard]] std::optional<Hdf5Id> open_hdf5_dataset(const std::filesystem::path& file, hid_t in,
                                                      const std::string& name, bool follow);

}  // namespace multitetra

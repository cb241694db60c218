// The arrays of VTK's XML files: as text, base64 or appended bytes, compressed or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/vtk/detail/vti_header.hpp"

namespace multitetra {

// The samples of an array as bytes, whatever is around them.
class SampleBytes {
 public:
  virtual ~SampleBytes() = default;
  // In host order. Throws VolumeFileError.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
};

class VtkArrays {
 public:
  // Throws VolumeFileError unless the file holds data of that kind.
  VtkArrays(const std::filesystem::path& file, VtkDataKind kind);

  [[nodiscard]] const VtiHeader& header() const { return header_; }
  // An array that must have `count` numbers, its components included. This object must outlive it.
  // Throws VolumeFileError.
  [[nodiscard]] std::unique_ptr<SampleBytes> open(const VtiArray& array, std::uint64_t count) const;

 private:
  InputFile file_;
  VtiHeader header_;
};

}  // namespace multitetra

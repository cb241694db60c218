// Reads the arrays of VTK's XML files: text, base64 or appended bytes, compressed or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/vtk/detail/vti_header.hpp"

namespace multitetra {

// The samples of an array as bytes, independent of their encoding.
class SampleBytes {
 public:
  virtual ~SampleBytes() = default;
  // Reads bytes in host order. Throws VolumeFileError.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
};

class VtkArrays {
 public:
  // Throws VolumeFileError unless the file contains data of `kind`.
  VtkArrays(const std::filesystem::path& file, VtkDataKind kind);

  [[nodiscard]] const VtiHeader& header() const { return header_; }
  // Opens an array of `count` numbers, including components. This object must outlive the result.
  // Throws VolumeFileError.
  [[nodiscard]] std::unique_ptr<SampleBytes> open(const VtiArray& array, std::uint64_t count) const;

 private:
  InputFile file_;
  VtiHeader header_;
};

}  // namespace multitetra

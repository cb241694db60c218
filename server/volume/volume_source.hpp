// A volume that returns its samples slab by slab, so that it need not fit in memory.
//
//   const auto source = open_volume("head.nhdr");  // volume_files.hpp
//   Samples slab;
//   for (std::int32_t z = 0; z < source->header().dims[2]; z += 16) {
//     source->read(z, std::min(16, source->header().dims[2] - z), slab);
//   }
//
// Guaranteed: slabs may be read in any order and repeatedly; together they are the result of
// read_volume(). Not safe to use from several threads at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/affine.hpp"
#include "server/core/framework/volume.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The properties of a volume that are known before its samples are read.
struct VolumeHeader {
  std::array<std::int32_t, 3> dims{};  // Samples along x, y, z; each 1 to kMaxSide.
  SampleType type = SampleType::kU8;   // Type of samples in slabs; the file may have a wider one.
  Vec3 spacing = {1, 1, 1};            // World units between samples, > 0.
  Affine index_to_world = {};          // Sample index -> world, including the spacing.
  PhysicalMeaning meaning = {};
  // Scaling, sign and missing values of the file, each with how it is known; for people.
  std::string values = {};

  [[nodiscard]] std::size_t samples_per_slice() const {
    return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]);
  }
};

[[nodiscard]] VolumeHeader header_of(const Volume& volume);

class VolumeSource {
 public:
  virtual ~VolumeSource() = default;

  [[nodiscard]] virtual const VolumeHeader& header() const = 0;

  // Reads slices first_slice to first_slice + slices - 1 as samples of header().type, x fastest.
  // NaN is void; no sample is infinite. Overwrites `into` and reuses its memory. Requires slices >=
  // 1, within the volume. Throws VolumeFileError.
  virtual void read(std::int32_t first_slice, std::int32_t slices, Samples& into) = 0;

  // Returns all slices. A source in memory gives its samples away, so this must be the last call.
  [[nodiscard]] virtual Samples take_all();

  // Returns PhysicalMeaning::rounding of the samples, once every slice has been read.
  [[nodiscard]] virtual std::string rounding() const { return {}; }

  // Returns further contents of the source, if its file lists them.
  [[nodiscard]] virtual const VolumeContents& contents() const;
};

}  // namespace multitetra

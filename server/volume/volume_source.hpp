// A volume that hands out its samples slab by slab, so that it need not fit in memory.
//
//   const auto source = open_volume("head.nhdr");  // volume_files.hpp
//   Samples slab;
//   for (std::int32_t z = 0; z < source->header().dims[2]; z += 16) {
//     source->read(z, std::min(16, source->header().dims[2] - z), slab);
//   }
//
// Guaranteed: slabs may be read in any order and more than once, and put together they are what
// read_volume returns. Not guaranteed: reading from several threads at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/base/affine.hpp"
#include "server/core/framework/volume.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Properties of a volume that are known before its samples are read.
struct VolumeHeader {
  std::array<std::int32_t, 3> dims{};  // Samples along x, y, z; each 1 to kMaxSide.
  SampleType type =
      SampleType::kU8;       // The type of samples in slabs; in the file it may be a wider one.
  Vec3 spacing = {1, 1, 1};  // World units between samples, > 0.
  Affine index_to_world;     // Sample index -> world, the spacing included.
  PhysicalMeaning meaning = {};

  [[nodiscard]] std::size_t samples_per_slice() const {
    return static_cast<std::size_t>(dims[0]) * static_cast<std::size_t>(dims[1]);
  }
};

[[nodiscard]] VolumeHeader header_of(const Volume& volume);

class VolumeSource {
 public:
  virtual ~VolumeSource() = default;

  [[nodiscard]] virtual const VolumeHeader& header() const = 0;

  // The slices first_slice ... first_slice + slices - 1 into `into`, x fastest, of header().type.
  // NaN is void, and no sample is infinite. What `into` held is lost; its memory is used again.
  // Requires slices >= 1 and that all are slices of the volume. Throws VolumeFileError.
  virtual void read(std::int32_t first_slice, std::int32_t slices, Samples& into) = 0;

  // All slices. A source that holds them gives them away, so this is the last call to it.
  [[nodiscard]] virtual Samples take_all();

  // Further contents of the source, if its file lists them.
  [[nodiscard]] virtual const VolumeContents& members() const;
};

// A volume in memory as a source.
[[nodiscard]] std::unique_ptr<VolumeSource> source_of(Volume volume);

}  // namespace multitetra

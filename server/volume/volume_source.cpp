#include "server/volume/volume_source.hpp"

namespace multitetra {

VolumeHeader header_of(const Volume& volume) {
  return {.dims = volume.dims,
          .type = volume.type(),
          .spacing = volume.spacing,
          .index_to_world = volume.index_to_world,
          .meaning = volume.meaning};
}

const VolumeContents& VolumeSource::contents() const {
  static const VolumeContents kNone;
  return kNone;
}

Samples VolumeSource::take_all() {
  Samples all;
  read(0, header().dims[2], all);
  return all;
}

}  // namespace multitetra

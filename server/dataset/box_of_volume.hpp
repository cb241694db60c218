// A box of a volume, read once from its source and kept in a file without a name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "server/core/spectrum/spectrum_inputs.hpp"
#include "server/dataset/detail/bricked_samples.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

class BoxOfVolume : public SampleBoxes {
 public:
  struct Options {
    std::filesystem::path folder;                    // Whose disk keeps it.
    std::size_t slab_bytes = std::size_t{64} << 20;  // Read at a time; a slice may be larger.
    std::function<void(std::uint64_t done, std::uint64_t all)> progress = nullptr;  // Samples.
  };

  // The samples from `begin` to `end`, which is exclusive. Requires a box that is not empty, of
  // samples of the volume, whose lower corner has multiples of 16. Throws VolumeFileError when the
  // source fails, DatasetFileError when the disk does.
  BoxOfVolume(VolumeSource& source, GridPoint begin, GridPoint end, const Options& options);
  ~BoxOfVolume() override;

  // Boxes inside of it, in the volume's own coordinates.
  void read(GridPoint first, GridPoint extent, Samples& into) const override;

 private:
  class Sink;

  GridPoint begin_;
  std::unique_ptr<Sink> sink_;
  std::unique_ptr<BrickedSamples> samples_;
};

}  // namespace multitetra

// A box of samples, read once from a volume's source and stored in an unnamed temporary file.
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
    std::filesystem::path folder;                    // Holds the temporary file.
    std::size_t slab_bytes = std::size_t{64} << 20;  // Bytes read at a time; a slice may exceed it.
    std::function<void(std::uint64_t done, std::uint64_t all)> progress = nullptr;  // Samples.
  };

  // Reads the samples from `begin` to `end` (exclusive). Requires a non-empty box within the volume
  // whose lower corner has coordinates that are multiples of 16. Throws VolumeFileError if the
  // source fails, DatasetFileError if the disk fails.
  BoxOfVolume(VolumeSource& source, GridPoint begin, GridPoint end, const Options& options);
  ~BoxOfVolume() override;

  // Reads a box within this one, in the coordinates of the volume.
  void read(GridPoint first, GridPoint extent, Samples& into) const override;

 private:
  class Sink;

  GridPoint begin_;
  std::unique_ptr<Sink> sink_;
  std::unique_ptr<BrickedSamples> samples_;
};

}  // namespace multitetra

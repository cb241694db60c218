// The input of a spectrum, and storage for intermediate data. Callers with files implement both.
#pragma once

#include "common/base/scratch.hpp"
#include "server/core/framework/grid.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

// A volume whose boxes of samples can be read in any order. Thread-safe.
class SampleBoxes {
 public:
  virtual ~SampleBoxes() = default;
  // Replaces `into`, reusing its memory, by the samples first ... first + extent - 1, x fastest and
  // of the volume's type. Requires samples inside the volume.
  virtual void read(GridPoint first, GridPoint extent, Samples& into) const = 0;
};

}  // namespace multitetra

// The input of a spectrum, and storage for intermediate bytes. Callers with files implement both.
#pragma once

#include "common/base/scratch.hpp"
#include "server/core/framework/grid.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

// A volume whose samples are read box by box, in any order. Safe to use from several threads at
// once.
class SampleBoxes {
 public:
  virtual ~SampleBoxes() = default;
  // The samples first ... first + extent - 1, x fastest, of the volume's type. What `into` held is
  // lost; its memory is used again. Requires that all of them are samples of the volume.
  virtual void read(GridPoint first, GridPoint extent, Samples& into) const = 0;
};

}  // namespace multitetra

// A prepared dataset: a volume with its facts. Immutable, shared by pointer-to-const among all
// sessions.
#pragma once

#include <cstdint>
#include <memory>

#include "common/dataset_info.hpp"
#include "common/lattice.hpp"
#include "server/core/volume.hpp"

namespace multitetra {

// The largest grid has 2^12 steps a side: with it every lattice resolution stays within
// kMaxLatticeBits.
inline constexpr std::int32_t kMaxGridExponent = 12;
static_assert(kMaxGridExponent + kMaxLatticeResolution <= kMaxLatticeBits);

struct Dataset {
  DatasetInfo info;
  Volume volume;
};

using DatasetPtr = std::shared_ptr<const Dataset>;

}  // namespace multitetra

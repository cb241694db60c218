// A prepared dataset: a volume with its facts. Immutable, shared by pointer-to-const among all
// sessions.
#pragma once

#include <memory>

#include "common/dataset_info.hpp"
#include "server/core/volume.hpp"

namespace multitetra {

struct Dataset {
  DatasetInfo info;
  Volume volume;
};

using DatasetPtr = std::shared_ptr<const Dataset>;

}  // namespace multitetra

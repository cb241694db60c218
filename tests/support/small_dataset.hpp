// The dataset of the golden file small.mtd: a slope of 3 x 2 x 2 samples.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "server/dataset/detail/statistics.hpp"

namespace multitetra {

inline DatasetPtr small_dataset() {
  Volume volume;
  volume.dims = {3, 2, 2};
  volume.spacing = {0.5, 1, 2};
  volume.index_to_world = {.columns = {Vec3{0.5, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 2}},
                           .translation = {-1, 0, 10}};
  volume.samples = std::vector<std::int16_t>{-2, -1, 0, 1, 2, 3, 0, 1, 2, 3, 4, 5};
  DatasetInfo info = describe(volume, "small", 0.0, 1);
  info.suggested_isovalues = {1.5};  // Fixed, because the golden file pins a format.
  return std::make_shared<const Dataset>(Dataset{std::move(info), std::move(volume)});
}

}  // namespace multitetra

#include "server/volume/labels/thin_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace multitetra {
namespace {

struct LabelSlice {
  std::vector<std::int32_t> labels;
  std::vector<std::uint8_t> is_thick;  // 1 if it lies in a cube of its label.

  explicit LabelSlice(std::size_t samples) : labels(samples), is_thick(samples) {}
};

// Marks the samples of all cubes between two slices.
void mark_cubes(LabelSlice& below, LabelSlice& above, std::size_t side) {
  for (std::size_t i = 0; i + side + 1 < below.labels.size(); ++i) {
    if (i % side == side - 1) continue;
    const std::int32_t label = below.labels[i];
    const std::array<std::size_t, 4> square = {i, i + 1, i + side, i + side + 1};
    const bool is_cube =
        label != 0 && std::all_of(square.begin(), square.end(), [&](std::size_t at) {
          return below.labels[at] == label && above.labels[at] == label;
        });
    if (!is_cube) continue;
    for (const std::size_t at : square) below.is_thick[at] = above.is_thick[at] = 1;
  }
}

}  // namespace

std::map<std::int32_t, std::uint64_t> thin_samples(
    const std::array<std::int32_t, 3>& dims,
    const std::function<void(std::int32_t, std::span<std::int32_t>)>& read) {
  const auto side = static_cast<std::size_t>(dims[0]);
  LabelSlice here(side * static_cast<std::size_t>(dims[1]));
  LabelSlice above = here;
  std::map<std::int32_t, std::uint64_t> thin;
  read(0, here.labels);
  for (std::int32_t z = 0; z < dims[2]; ++z) {
    if (z + 1 < dims[2]) {
      read(z + 1, above.labels);
      mark_cubes(here, above, side);
    }
    for (std::size_t i = 0; i < here.labels.size(); ++i) {
      const std::int32_t label = here.labels[i];
      if (here.is_thick[i] == 0 && label != 0) ++thin[label];
    }
    std::swap(here, above);
    std::fill(above.is_thick.begin(), above.is_thick.end(), std::uint8_t{0});
  }
  return thin;
}

}  // namespace multitetra

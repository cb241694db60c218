#include "server/extraction/detail/shell_size.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

// The edges of a uniform level run along axes and diagonals. On average over all orientations, a
// surface crosses three times as many as along axes alone.
constexpr double kVerticesPerAxisCrossing = 3;
// The growth in triangles when a level's spacing is halved.
constexpr double kTrianglesPerHalvedLevel = 4.3;

// Counts neighbours along an axis on different sides, among every `step`-th coarse sample.
template <typename Sample>
double axis_crossings(const PreparedVolume& volume, double isovalue, std::int32_t step) {
  const LevelExtent all = coarse_extent(volume.info);
  const std::span<const std::byte> bytes = volume.coarse.bytes();
  const auto first = [step](std::int32_t low) { return (low + step - 1) / step * step; };
  const GridPoint begin = {first(all.low.x), first(all.low.y), first(all.low.z)};
  const GridPoint end = all.low + all.extent;
  const auto sample = [&](GridPoint p) {
    Sample value;
    std::memcpy(&value, bytes.data() + sizeof(Sample) * all.index(p), sizeof(Sample));
    return static_cast<double>(value);
  };
  double crossings = 0;
  GridPoint p;
  for (p.z = begin.z; p.z < end.z; p.z += step) {
    for (p.y = begin.y; p.y < end.y; p.y += step) {
      for (p.x = begin.x; p.x < end.x; p.x += step) {
        const double value = sample(p);
        if (std::isnan(value)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const GridPoint next = p + step * unit(axis);
          if (next[axis] >= end[axis]) continue;
          const double other = sample(next);
          if (!std::isnan(other) && (value > isovalue) != (other > isovalue)) ++crossings;
        }
      }
    }
  }
  return crossings;
}

}  // namespace

SurfaceSize shell_size(const PreparedVolume& volume, const StepRequest& step) {
  const std::int32_t coarse = std::max(step.finest_spacing, kSpectrumSpacing);
  const double crossings = visit_type(volume.info.type, [&]<typename Sample>(const Sample*) {
    return axis_crossings<Sample>(volume, step.request.isovalue, coarse / kSpectrumSpacing);
  });
  const double halvings = std::log2(coarse / static_cast<double>(step.finest_spacing));
  const double triangles =
      2 * kVerticesPerAxisCrossing * crossings * std::pow(kTrianglesPerHalvedLevel, halvings);
  return {.triangles = triangles,
          .bytes = estimated_bytes(triangles, step, volume.info.type),
          .extracted = triangles};
}

}  // namespace multitetra

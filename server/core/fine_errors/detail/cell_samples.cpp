#include "server/core/fine_errors/detail/cell_samples.hpp"

#include <algorithm>

namespace multitetra {
namespace {

constexpr std::int32_t kBrick = BrickLayout::kSampleSide;

// A box of samples in data indices; `end` is exclusive.
struct SampleBox {
  GridPoint begin;
  GridPoint end;

  [[nodiscard]] bool is_empty() const {
    return begin.x >= end.x || begin.y >= end.y || begin.z >= end.z;
  }
  [[nodiscard]] SampleBox within(GridPoint low, GridPoint high) const {
    const auto clamped = [&](GridPoint p) {
      return GridPoint{std::clamp(p.x, low.x, high.x), std::clamp(p.y, low.y, high.y),
                       std::clamp(p.z, low.z, high.z)};
    };
    return {clamped(begin), clamped(end)};
  }
};

}  // namespace

CellSamples::CellSamples(const PreparedVolume& volume, GridPoint low, GridPoint high)
    : volume_(volume), layout_(volume.info.dims) {
  const GridPoint origin = first_sample(volume.info);
  const auto brick = [&](GridPoint p, int axis) {
    const std::int32_t end = volume.info.dims[static_cast<std::size_t>(axis)];
    return std::clamp(p[axis] - origin[axis], 0, end - 1) / kBrick;
  };
  first_ = {brick(low, 0), brick(low, 1), brick(low, 2)};
  const auto count = [&](int axis) { return brick(high, axis) - first_[axis] + 1; };
  row_ = count(0);
  slice_ = row_ * count(1);
  bricks_.resize(static_cast<std::size_t>(slice_ * count(2)));
}

const std::byte* CellSamples::brick(GridPoint at) {
  const GridPoint p = at - first_;
  RetainedBytes& bytes = bricks_[static_cast<std::size_t>(p.x + row_ * p.y + slice_ * p.z)];
  if (bytes.empty()) bytes = volume_.samples->brick(layout_.index({at.x, at.y, at.z}));
  return bytes.data();
}

void CellSamples::load_cell(GridPoint low, float* into, std::ptrdiff_t row, std::ptrdiff_t slice) {
  const DatasetInfo& info = volume_.info;
  const GridPoint begin = low - first_sample(info);  // The cell may extend beyond the data.
  const SampleBox cell = {begin,
                          begin + GridPoint{kSpectrumSpacing, kSpectrumSpacing, kSpectrumSpacing}};
  const SampleBox box = cell.within({}, {info.dims[0], info.dims[1], info.dims[2]});
  const auto at = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    return into + (x - begin.x) + row * (y - begin.y) + slice * (z - begin.z);
  };
  if (box.begin != cell.begin || box.end != cell.end) {
    for (std::int32_t z = cell.begin.z; z < cell.end.z; ++z) {
      for (std::int32_t y = cell.begin.y; y < cell.end.y; ++y) {
        std::fill_n(at(begin.x, y, z), kSpectrumSpacing, outside_value(info));
      }
    }
    if (box.is_empty()) return;
  }
  visit_type(info.type, [&]<typename Sample>(const Sample*) {
    for (std::int32_t bz = box.begin.z / kBrick; bz * kBrick < box.end.z; ++bz) {
      for (std::int32_t by = box.begin.y / kBrick; by * kBrick < box.end.y; ++by) {
        for (std::int32_t bx = box.begin.x / kBrick; bx * kBrick < box.end.x; ++bx) {
          const auto* const samples = reinterpret_cast<const Sample*>(brick({bx, by, bz}));
          const GridCounts extent = layout_.extent({bx, by, bz});
          const GridPoint first = {kBrick * bx, kBrick * by, kBrick * bz};
          const SampleBox part = box.within(first, first + GridPoint{kBrick, kBrick, kBrick});
          for (std::int32_t z = part.begin.z; z < part.end.z; ++z) {
            for (std::int32_t y = part.begin.y; y < part.end.y; ++y) {
              const Sample* const from =
                  samples + (part.begin.x - first.x) +
                  std::ptrdiff_t{extent[0]} *
                      ((y - first.y) + std::ptrdiff_t{extent[1]} * (z - first.z));
              float* const to = at(part.begin.x, y, z);
              for (std::int32_t i = 0; i < part.end.x - part.begin.x; ++i) {
                to[i] = static_cast<float>(from[i]);
              }
            }
          }
        }
      }
    }
  });
}

}  // namespace multitetra

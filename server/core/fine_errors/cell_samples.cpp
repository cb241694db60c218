#include "server/core/fine_errors/cell_samples.hpp"

#include <algorithm>

namespace multitetra {
namespace {

constexpr std::int32_t kBrick = BrickLayout::kSampleSide;

// A box of samples, by their indices in the data; `end` is exclusive.
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

void load_cell(const PreparedVolume& volume, GridPoint low, float* into, std::ptrdiff_t row,
               std::ptrdiff_t slice) {
  const DatasetInfo& info = volume.info;
  const GridPoint begin = low - first_sample(info);  // The cell may reach over the data.
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
  const BrickLayout layout(info.dims);
  visit_type(info.type, [&]<typename Sample>(const Sample*) {
    for (std::int32_t bz = box.begin.z / kBrick; bz * kBrick < box.end.z; ++bz) {
      for (std::int32_t by = box.begin.y / kBrick; by * kBrick < box.end.y; ++by) {
        for (std::int32_t bx = box.begin.x / kBrick; bx * kBrick < box.end.x; ++bx) {
          const KeptBytes bytes = volume.samples->brick(layout.index({bx, by, bz}));
          const auto* const brick = reinterpret_cast<const Sample*>(bytes.data());
          const GridCounts extent = layout.extent({bx, by, bz});
          const GridPoint first = {kBrick * bx, kBrick * by, kBrick * bz};
          const SampleBox part = box.within(first, first + GridPoint{kBrick, kBrick, kBrick});
          for (std::int32_t z = part.begin.z; z < part.end.z; ++z) {
            for (std::int32_t y = part.begin.y; y < part.end.y; ++y) {
              const Sample* const from =
                  brick + (part.begin.x - first.x) +
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

#include "common/dataset/dataset_info.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/enum_names.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<SampleType, 5> kTypes = {{"u8", "i8", "u16", "i16", "f32"}};

}  // namespace

std::string_view name(SampleType type) { return kTypes.of(type); }

std::optional<SampleType> sample_type_from(std::string_view name) { return kTypes.find(name); }

int bytes_per_sample(SampleType type) {
  return visit_type(
      type, []<typename Sample>(const Sample*) { return static_cast<int>(sizeof(Sample)); });
}

std::int32_t grid_exponent_for(const std::array<std::int32_t, 3>& dims, std::int32_t margin) {
  const std::int64_t steps =
      std::int64_t{*std::max_element(dims.begin(), dims.end())} - 1 + 2 * std::int64_t{margin};
  std::int32_t exponent = 1;
  while ((std::int64_t{1} << exponent) < steps) ++exponent;
  return exponent;
}

double voxel_length(const DatasetInfo& info) {
  return *std::min_element(info.spacing.begin(), info.spacing.end());
}

Affine grid_to_index(const DatasetInfo& info) {
  const double shift = -static_cast<double>(info.margin);
  return {.columns = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}},
          .translation = {shift, shift, shift}};
}

Affine grid_to_world(const DatasetInfo& info) {
  Affine map = info.index_to_world;
  map.translation = info.index_to_world(grid_to_index(info).translation);
  return map;
}

double longest_cell_diagonal(const DatasetInfo& info) {
  const auto& [x, y, z] = info.index_to_world.columns;
  double longest = 0;
  for (const double y_sign : {-1.0, 1.0}) {
    for (const double z_sign : {-1.0, 1.0}) {
      longest = std::max(longest, length(moved(moved(x, y_sign, y), z_sign, z)));
    }
  }
  return longest;
}

double lattice_rounding_world(const DatasetInfo& info, int lattice_resolution) {
  return std::ldexp(longest_cell_diagonal(info), -lattice_resolution);
}

DataBorder data_border(const DatasetInfo& info, int lattice_resolution, double topology_tolerance,
                       std::int32_t finest_spacing) {
  DataBorder border;
  border.anywhere = info.void_samples > 0;
  const std::int32_t step = std::int32_t{1} << lattice_resolution;
  if (info.outside) {
    const std::int32_t side = (std::int32_t{1} << info.grid_exponent) * step;
    border.high = {side, side, side};
    return border;
  }
  const std::int32_t low = info.margin * step;
  border.low = {low, low, low};
  border.high = {low + (info.dims[0] - 1) * step, low + (info.dims[1] - 1) * step,
                 low + (info.dims[2] - 1) * step};
  // The extent of the tetrahedra that may reach beyond the border.
  std::int32_t longest = finest_spacing;
  for (std::int32_t spacing = 1;
       spacing <= topology_tolerance && spacing <= (1 << info.grid_exponent); spacing *= 2) {
    longest = std::max(longest, 2 * spacing);
  }
  border.inset = (longest - 1) * step;
  return border;
}

}  // namespace multitetra

#include "common/request/request_key.hpp"

#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "common/dataset/surface_name.hpp"

namespace multitetra {
namespace {

// Builds a key from parts that have a known length or are preceded by their length.
class Key {
 public:
  template <typename Number>
  requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void add(Number number) {
    if constexpr (std::is_floating_point_v<Number>) {
      if (number == 0) number = 0;  // Replaces negative zero.
      if (std::isnan(number)) number = std::numeric_limits<Number>::quiet_NaN();
    }
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  void add(const Vec3& vector) {
    for (const double number : vector) add(number);
  }
  void add(const BoxShape& box) {
    add(box.low);
    add(box.high);
  }
  void add(const BallShape& ball) {
    add(ball.center);
    add(ball.radius);
  }
  void add(const HalfSpaceShape& half_space) {
    add(half_space.normal);
    add(half_space.offset);
  }
  void add(const ThresholdRegion& region) {
    add(region.shape.index());
    std::visit([this](const auto& shape) { add(shape); }, region.shape);
    add(region.threshold);
  }
  void add(const ThresholdGrid& grid) {
    for (const std::int32_t side : grid.dims) add(side);
    for (const Vec3& column : grid.index_to_world.columns) add(column);
    add(grid.index_to_world.translation);
    for (const float threshold : grid.thresholds) add(threshold);
  }
  void add(const Frustum& frustum) {
    add(frustum.look_at);
    add(frustum.up);
    add(frustum.aspect);
    add(frustum.outside);
  }
  void add(const ThresholdView& view) {
    add(view.eye);
    add(view.field_of_view);
    add(view.height_pixels);
    add(view.tolerance_pixels);
    add_if(view.frustum ? &*view.frustum : nullptr);
  }
  void add(const OctreeNode& cell) {
    for (const std::int32_t number :
         {cell.cube.exponent, cell.cube.x, cell.cube.y, cell.cube.z, cell.finest_spacing}) {
      add(number);
    }
  }
  template <typename Part>
  void add_if(const Part* part) {
    add(part != nullptr);
    if (part != nullptr) add(*part);
  }
  void add(const LocalThresholds& thresholds) {
    add(thresholds.coordinates);
    add(thresholds.combination);
    add(thresholds.regions.size());
    for (const ThresholdRegion& region : thresholds.regions) add(region);
    add_if(thresholds.grid.get());
    add_if(thresholds.view ? &*thresholds.view : nullptr);
    add(thresholds.error_floor);
  }

  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace

std::string key_of(const IsosurfaceRequest& request) {
  Key key;
  key.add(request.isovalue);
  key.add(request.error);
  key.add(request.unit);
  key.add(request.error_measure);
  key.add(request.topology_rule);
  key.add(request.topology_tolerance);
  key.add(request.lattice_resolution);
  key.add(request.max_triangles);
  key.add(request.max_bytes);
  key.add(request.simplify);
  key.add(request.intersection_free);
  key.add(request.normal_bits);
  key.add_if(request.cell ? &*request.cell : nullptr);
  key.add(request.thresholds);
  return key.take();
}

std::string key_of(const DatasetInfo& info) {
  Key key;
  key.add(info.content_id);
  for (const std::int32_t side : info.dims) key.add(side);
  for (const Vec3& column : info.index_to_world.columns) key.add(column);
  key.add(info.index_to_world.translation);
  key.add(info.spacing);
  key.add(info.outside.has_value());
  key.add(info.outside.value_or(0));
  key.add(info.margin);
  const SurfaceName name = surface_name(info);  // Mesh files contain it.
  key.add(name.label.has_value());
  key.add(name.label.value_or(0));
  key.add(name.color.value_or(0));
  key.add(name.color.has_value());
  key.add(name.text.size());
  return key.take() + name.text + info.name;
}

}  // namespace multitetra

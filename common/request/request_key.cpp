#include "common/request/request_key.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "common/dataset/surface_name.hpp"

namespace multitetra {
namespace {

// Builds a key from parts that have a known length or are preceded by their length or presence.
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
  template <typename Item, std::size_t count>
  void add(const std::array<Item, count>& items) {
    for (const Item& item : items) add(item);
  }
  void add(const Affine& map) { add_all(map.columns, map.translation); }
  void add(const std::string& text) {
    add(text.size());
    bytes_ += text;
  }
  void add(const PhysicalMeaning& meaning) {
    add_all(meaning.space, meaning.length_unit, meaning.value_unit, meaning.geometry,
            meaning.assumed, meaning.rounding);
  }
  void add(const BoxShape& box) { add_all(box.low, box.high); }
  void add(const BallShape& ball) { add_all(ball.center, ball.radius); }
  void add(const HalfSpaceShape& half_space) { add_all(half_space.normal, half_space.offset); }
  void add(const ThresholdRegion& region) {
    add(region.shape.index());
    std::visit([this](const auto& shape) { add(shape); }, region.shape);
    add(region.threshold);
  }
  void add(const ThresholdGrid& grid) {
    add_all(grid.dims, grid.index_to_world);
    for (const float threshold : grid.thresholds) add(threshold);
  }
  void add(const Frustum& frustum) {
    add_all(frustum.look_at, frustum.up, frustum.aspect, frustum.outside);
  }
  void add(const ThresholdView& view) {
    add_all(view.eye, view.field_of_view, view.height_pixels, view.tolerance_pixels, view.frustum);
  }
  void add(const OctreeNode& cell) {
    add_all(cell.cube.exponent, cell.cube.x, cell.cube.y, cell.cube.z, cell.finest_spacing);
  }
  void add(const LocalThresholds& thresholds) {
    add_all(thresholds.coordinates, thresholds.combination, thresholds.regions.size());
    for (const ThresholdRegion& region : thresholds.regions) add(region);
    add_optional(thresholds.grid);
    add_all(thresholds.view, thresholds.error_floor);
  }
  template <typename Part>
  void add(const std::optional<Part>& part) {
    add_optional(part);
  }
  template <typename Pointer>
  void add_optional(const Pointer& part) {
    add(static_cast<bool>(part));
    if (part) add(*part);
  }
  template <typename... Parts>
  void add_all(const Parts&... parts) {
    (add(parts), ...);
  }

  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace

std::string key_of(const IsosurfaceRequest& request) {
  Key key;
  key.add_all(request.isovalue, request.error, request.unit, request.error_measure,
              request.topology_rule, request.topology_tolerance, request.lattice_resolution,
              request.max_triangles, request.max_bytes, request.simplify, request.intersection_free,
              request.normal_bits, request.cell, request.thresholds);
  return key.take();
}

std::string key_of(const DatasetInfo& info) {
  const SurfaceName name = surface_name(info);  // Mesh files contain it, as the meaning.
  Key key;
  key.add_all(info.content_id, info.dims, info.index_to_world, info.spacing, info.outside,
              info.margin, info.meaning, name.label, name.color, name.text);
  return key.take() + info.name;
}

}  // namespace multitetra

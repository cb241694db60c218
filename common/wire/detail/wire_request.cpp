#include "common/wire/detail/wire_request.hpp"

#include <algorithm>
#include <memory>
#include <string>

#include "common/request/default_error.hpp"
#include "common/wire/detail/wire_vectors.hpp"

namespace multitetra::wire {
namespace {

// ---- regions

void write(const BoxShape& box, v1::ThresholdRegion& wire) {
  write_vec3(box.low, *wire.mutable_box()->mutable_low());
  write_vec3(box.high, *wire.mutable_box()->mutable_high());
}
void write(const BallShape& ball, v1::ThresholdRegion& wire) {
  write_vec3(ball.center, *wire.mutable_ball()->mutable_center());
  wire.mutable_ball()->set_radius(ball.radius);
}
void write(const HalfSpaceShape& half_space, v1::ThresholdRegion& wire) {
  write_vec3(half_space.normal, *wire.mutable_half_space()->mutable_normal());
  wire.mutable_half_space()->set_offset(half_space.offset);
}

ThresholdRegion read(const v1::ThresholdRegion& wire, FieldChecks& checks) {
  ThresholdRegion region{.threshold = wire.threshold()};
  switch (wire.shape_case()) {
    case v1::ThresholdRegion::kBox:
      region.shape =
          BoxShape{.low = read_vec3("ThresholdRegion.box.low", wire.box().low(), checks),
                   .high = read_vec3("ThresholdRegion.box.high", wire.box().high(), checks)};
      break;
    case v1::ThresholdRegion::kBall:
      region.shape = BallShape{
          .center = read_vec3("ThresholdRegion.ball.center", wire.ball().center(), checks),
          .radius = wire.ball().radius()};
      break;
    case v1::ThresholdRegion::kHalfSpace:
      region.shape = HalfSpaceShape{.normal = read_vec3("ThresholdRegion.half_space.normal",
                                                        wire.half_space().normal(), checks),
                                    .offset = wire.half_space().offset()};
      break;
    case v1::ThresholdRegion::SHAPE_NOT_SET:
      checks.fail(ErrorCode::kInvalidArgument,
                  "ThresholdRegion.shape has an unknown kind; valid kinds: box, ball, half_space.");
  }
  return region;
}

// ---- the grid

void write(const ThresholdGrid& grid, v1::ThresholdGrid& wire) {
  for (const std::int32_t samples : grid.dims) wire.add_dims(static_cast<std::uint32_t>(samples));
  for (const Vec3& column : grid.index_to_world.columns) {
    for (const double number : column) wire.add_index_to_world(number);
  }
  for (const double number : grid.index_to_world.translation) wire.add_index_to_world(number);
  wire.mutable_thresholds()->Assign(grid.thresholds.begin(), grid.thresholds.end());
}

ThresholdGrid read(const v1::ThresholdGrid& wire, FieldChecks& checks) {
  checks.exactly("ThresholdGrid.dims", wire.dims_size(), 3);
  checks.exactly("ThresholdGrid.index_to_world", wire.index_to_world_size(), 12);
  checks.at_most("ThresholdGrid.thresholds", static_cast<std::size_t>(wire.thresholds_size()),
                 kMaxGridThresholds, "thresholds");
  ThresholdGrid grid;
  if (checks.first()) return grid;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    checks.integer("ThresholdGrid.dims", wire.dims(axis), 1, kMaxGridThresholds);
    grid.dims[at] = static_cast<std::int32_t>(wire.dims(axis));
    std::copy_n(wire.index_to_world().begin() + 3 * axis, 3,
                grid.index_to_world.columns[at].begin());
  }
  std::copy_n(wire.index_to_world().begin() + 9, 3, grid.index_to_world.translation.begin());
  grid.thresholds.assign(wire.thresholds().begin(), wire.thresholds().end());
  return grid;
}

// ---- the view

void write(const ThresholdView& view, v1::ThresholdView& wire) {
  write_vec3(view.eye, *wire.mutable_eye());
  wire.set_field_of_view(view.field_of_view);
  wire.set_height_pixels(view.height_pixels);
  wire.set_tolerance_pixels(view.tolerance_pixels);
  if (!view.frustum) return;
  v1::Frustum& frustum = *wire.mutable_frustum();
  write_vec3(view.frustum->look_at, *frustum.mutable_look_at());
  write_vec3(view.frustum->up, *frustum.mutable_up());
  frustum.set_aspect(view.frustum->aspect);
  frustum.set_outside(view.frustum->outside);
}

Frustum read(const v1::Frustum& wire, FieldChecks& checks) {
  Frustum frustum{.look_at = read_vec3("Frustum.look_at", wire.look_at(), checks),
                  .outside = wire.outside()};
  if (!wire.up().empty()) frustum.up = read_vec3("Frustum.up", wire.up(), checks);
  if (wire.aspect() != 0) frustum.aspect = wire.aspect();
  return frustum;
}

ThresholdView read(const v1::ThresholdView& wire, FieldChecks& checks) {
  ThresholdView view{.eye = read_vec3("ThresholdView.eye", wire.eye(), checks),
                     .field_of_view = wire.field_of_view(),
                     .height_pixels = wire.height_pixels(),
                     .tolerance_pixels = wire.tolerance_pixels()};
  if (wire.has_frustum()) view.frustum = read(wire.frustum(), checks);
  return view;
}

// ---- the map

// Omits defaults, to keep requests without a map short.
void write(const LocalThresholds& thresholds, v1::ThresholdMap& wire) {
  if (thresholds.coordinates != CoordinateSystem{}) {
    wire.set_region_coordinates(to_wire<v1::CoordinateSystem>(thresholds.coordinates));
  }
  if (thresholds.combination != Combination{}) {
    wire.set_combine(to_wire<v1::Combination>(thresholds.combination));
  }
  for (const ThresholdRegion& region : thresholds.regions) {
    v1::ThresholdRegion& wire_region = *wire.add_regions();
    wire_region.set_threshold(region.threshold);
    std::visit([&](const auto& shape) { write(shape, wire_region); }, region.shape);
  }
  if (thresholds.grid) write(*thresholds.grid, *wire.mutable_threshold_grid());
  if (thresholds.view) write(*thresholds.view, *wire.mutable_view());
  wire.set_at_least(thresholds.error_floor);
}

LocalThresholds read(const v1::ThresholdMap& wire, FieldChecks& checks) {
  LocalThresholds thresholds;
  thresholds.coordinates = checks.enumerator<CoordinateSystem>(
      "IsosurfaceRequest.threshold.region_coordinates", wire.region_coordinates(),
      CoordinateSystem::kIndex, CoordinateSystem::kWorld);
  thresholds.combination =
      checks.enumerator<Combination>("IsosurfaceRequest.threshold.combine", wire.combine(),
                                     Combination::kMinimum, Combination::kInOrder);
  thresholds.regions.reserve(static_cast<std::size_t>(wire.regions_size()));
  for (const v1::ThresholdRegion& region : wire.regions()) {
    thresholds.regions.push_back(read(region, checks));
  }
  if (wire.has_threshold_grid()) {
    thresholds.grid = std::make_shared<const ThresholdGrid>(read(wire.threshold_grid(), checks));
  }
  if (wire.has_view()) thresholds.view = read(wire.view(), checks);
  thresholds.error_floor = wire.at_least();
  return thresholds;
}

void write(const OctreeNode& cell, v1::SurfaceCell& wire) {
  wire.set_exponent(static_cast<std::uint32_t>(cell.cube.exponent));
  wire.set_x(static_cast<std::uint32_t>(cell.cube.x));
  wire.set_y(static_cast<std::uint32_t>(cell.cube.y));
  wire.set_z(static_cast<std::uint32_t>(cell.cube.z));
  wire.set_finest_spacing(static_cast<std::uint32_t>(cell.finest_spacing));
}

// Converts an unsigned number of the wire to int. Larger numbers are out of range in any case.
int to_int(std::uint32_t number) {
  return static_cast<int>(std::min<std::uint32_t>(number, 1000000));
}

OctreeNode read(const v1::SurfaceCell& wire) {
  // Larger numbers are out of range in any case.
  const auto within = [most = std::uint32_t{1} << kMaxLatticeBits](std::uint32_t number) {
    return static_cast<std::int32_t>(std::min(number, most));
  };
  return {.cube = {.exponent = within(wire.exponent()),
                   .x = within(wire.x()),
                   .y = within(wire.y()),
                   .z = within(wire.z())},
          .finest_spacing = std::max(within(wire.finest_spacing()), 1)};
}

}  // namespace

void write_request(const IsosurfaceRequest& request, v1::IsosurfaceRequest& wire) {
  wire.set_isovalue(request.isovalue);
  wire.mutable_threshold()->set_error(request.error);
  wire.mutable_threshold()->set_unit(to_wire<v1::ErrorUnit>(request.unit));
  write(request.thresholds, *wire.mutable_threshold());
  wire.set_bound(to_wire<v1::ErrorMeasure>(request.error_measure));
  wire.set_topology_rule(to_wire<v1::TopologyRule>(request.topology_rule));
  wire.set_topology_tolerance(request.topology_tolerance);
  wire.set_lattice(static_cast<std::uint32_t>(request.lattice_resolution));
  wire.set_max_triangles(request.max_triangles);
  wire.set_max_bytes(request.max_bytes);
  wire.set_simplify(request.simplify);
  wire.set_intersection_free(request.intersection_free);
  wire.set_normals(static_cast<std::uint32_t>(request.normal_bits));
  if (request.cell) write(*request.cell, *wire.mutable_cell());
}

IsosurfaceRequest read_request(const v1::IsosurfaceRequest& wire, FieldChecks& checks) {
  IsosurfaceRequest request;
  request.isovalue = wire.isovalue();
  request.error = wire.threshold().has_error() ? wire.threshold().error() : kDefaultError;
  request.unit =
      checks.enumerator<ErrorUnit>("IsosurfaceRequest.threshold.unit", wire.threshold().unit(),
                                   ErrorUnit::kWorld, ErrorUnit::kVoxel);
  request.thresholds = read(wire.threshold(), checks);
  request.error_measure = checks.enumerator<ErrorMeasure>(
      "IsosurfaceRequest.bound", wire.bound(), ErrorMeasure::kPaper, ErrorMeasure::kCertified);
  request.topology_rule =
      checks.enumerator<TopologyRule>("IsosurfaceRequest.topology_rule", wire.topology_rule(),
                                      TopologyRule::kPaper, TopologyRule::kExact);
  request.topology_tolerance = wire.topology_tolerance();
  if (wire.lattice() != 0) {
    request.lattice_resolution = to_int(wire.lattice());
  }
  request.max_triangles = wire.max_triangles();
  request.max_bytes = wire.max_bytes();
  request.simplify = !wire.has_simplify() || wire.simplify();
  request.intersection_free = wire.intersection_free();
  request.normal_bits = to_int(wire.normals());
  if (wire.has_cell()) request.cell = read(wire.cell());
  checks.valid(validated(request));
  return request;
}

}  // namespace multitetra::wire

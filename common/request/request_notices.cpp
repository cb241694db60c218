#include "common/request/request_notices.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <variant>

#include "common/base/number_text.hpp"

namespace multitetra {
namespace {

BoxShape box_around(const Affine& map, const BoxShape& box) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  BoxShape around{.low = {kFar, kFar, kFar}, .high = {-kFar, -kFar, -kFar}};
  for (const double x : {box.low[0], box.high[0]}) {
    for (const double y : {box.low[1], box.high[1]}) {
      for (const double z : {box.low[2], box.high[2]}) {
        const Vec3 corner = map(Vec3{x, y, z});
        for (std::size_t axis = 0; axis < 3; ++axis) {
          around.low[axis] = std::min(around.low[axis], corner[axis]);
          around.high[axis] = std::max(around.high[axis], corner[axis]);
        }
      }
    }
  }
  return around;
}

bool are_disjoint(const BoxShape& a, const BoxShape& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.high[axis] < b.low[axis] || b.high[axis] < a.low[axis]) return true;
  }
  return false;
}

// Returns the box of the samples in sample indices, extended by one sample on every side.
BoxShape data_box(const DatasetInfo& info) {
  BoxShape box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = -1;
    box.high[axis] = info.dims[axis];
  }
  return box;
}

// Tests whether a shape is disjoint from the box. `map` maps the box to the shape's coordinates.
// Boxes are compared in both coordinate systems, which detects more cases than one.
class IsApart {
 public:
  IsApart(const BoxShape& data, const Affine& map)
      : data_(data), map_(map), around_(box_around(map, data)) {}

  bool operator()(const BoxShape& box) const {
    return are_disjoint(box, around_) || are_disjoint(box_around(inverse(map_), box), data_);
  }
  bool operator()(const BallShape& ball) const {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double nearest =
          std::clamp(ball.center[axis], around_.low[axis], around_.high[axis]) - ball.center[axis];
      square += nearest * nearest;
    }
    return square > ball.radius * ball.radius;
  }
  bool operator()(const HalfSpaceShape& half_space) const {
    double farthest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double n = half_space.normal[axis];
      farthest += n * (n > 0 ? around_.high[axis] : around_.low[axis]);
    }
    return farthest < half_space.offset;
  }

 private:
  BoxShape data_;
  Affine map_;
  BoxShape around_;
};

std::string place_text(const Vec3& place) {
  return "(" + shortest_text(place[0]) + ", " + shortest_text(place[1]) + ", " +
         shortest_text(place[2]) + ")";
}

std::string whole_data_text(const LocalThresholds& thresholds, const DatasetInfo& info) {
  BoxShape samples;
  for (std::size_t axis = 0; axis < 3; ++axis) samples.high[axis] = info.dims[axis] - 1;
  const bool is_world = thresholds.coordinates == CoordinateSystem::kWorld;
  const BoxShape box = is_world ? box_around(info.index_to_world, samples) : samples;
  return "its samples range from " + place_text(box.low) + " to " + place_text(box.high) + " in " +
         (is_world ? "world coordinates" : "sample indices");
}

bool is_outside_values(const IsosurfaceRequest& request, const DatasetInfo& info) {
  const double least = std::min(info.min, info.outside.value_or(info.min));
  const double largest = std::max(info.max, info.outside.value_or(info.max));
  return request.isovalue < least || request.isovalue >= largest;
}

std::string values_text(const DatasetInfo& info) {
  std::uint64_t samples = 1;
  for (const std::int32_t side : info.dims) samples *= static_cast<std::uint64_t>(side);
  if (info.void_samples == samples) return "all samples of \"" + info.name + "\" are void";
  return "values of \"" + info.name + "\" range from " + shortest_text(info.min) + " to " +
         shortest_text(info.max);
}

}  // namespace

std::vector<std::string> request_notices(const IsosurfaceRequest& request,
                                         const DatasetInfo& info) {
  std::vector<std::string> notices;
  if (is_outside_values(request, info)) notices.push_back(empty_surface_text(request, info));
  if (request.unit == ErrorUnit::kWorld && has_assumed_spacing(info.meaning)) {
    notices.push_back("Lengths are not measured: the source of \"" + info.name +
                      "\" does not state all of them (assumed: " + info.meaning.assumed + ").");
  }
  if (std::string text = rounding_text(info.name, info.meaning); !text.empty()) {
    notices.push_back(std::move(text));
  }
  const LocalThresholds& thresholds = request.thresholds;
  const bool is_world = thresholds.coordinates == CoordinateSystem::kWorld;
  const IsApart is_apart(data_box(info), is_world ? info.index_to_world : Affine{});
  std::vector<std::size_t> outside;
  for (std::size_t i = 0; i < thresholds.regions.size(); ++i) {
    if (std::visit(is_apart, thresholds.regions[i].shape)) outside.push_back(i + 1);
  }
  if (!outside.empty()) {
    notices.push_back((outside.size() == 1 ? "Region " + std::to_string(outside.front()) + " is"
                                           : std::to_string(outside.size()) +
                                                 " regions, the first of them region " +
                                                 std::to_string(outside.front()) + ", are") +
                      " outside \"" + info.name +
                      "\" and without effect: " + whole_data_text(thresholds, info) + ".");
  }
  if (thresholds.grid) {
    BoxShape voxels{.low = {-0.5, -0.5, -0.5}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      voxels.high[axis] = thresholds.grid->dims[axis] - 0.5;
    }
    const BoxShape box = box_around(thresholds.grid->index_to_world, voxels);
    if (IsApart(data_box(info), info.index_to_world)(box)) {
      notices.push_back("The grid of thresholds is outside \"" + info.name +
                        "\" and without effect: it extends from " + place_text(box.low) + " to " +
                        place_text(box.high) + " in world coordinates.");
    }
  }
  // A budget raises the floor only. With an error of 0 the best surface that fits is expected.
  const double raised = thresholds.error_floor;
  if (has_budget(request) && request.error > 0 && raised > 2 * request.error) {
    const std::string& unit = info.meaning.length_unit;
    notices.push_back("The budget raised the error from " + rounded_text(request.error) + " to " +
                      rounded_text(raised) + " " +
                      (request.unit == ErrorUnit::kVoxel ? "voxels"
                       : unit.empty()                    ? "units"
                                                         : unit) +
                      ".");
  }
  return notices;
}

std::string empty_surface_text(const IsosurfaceRequest& request, const DatasetInfo& info) {
  if (is_outside_values(request, info)) {
    return "The surface is empty: there is no surface at isovalue " +
           shortest_text(request.isovalue) + "; " + values_text(info) + ".";
  }
  return "The surface is empty: no surface remains at isovalue " + shortest_text(request.isovalue) +
         (request.topology_tolerance > 0 ? " at this topology tolerance" : " inside the data") +
         "; " + values_text(info) + ".";
}

std::string filled_text(const FilledCavities& filled) {
  return "removal fills " + std::to_string(filled.count) +
         (filled.count == 1 ? " cavity, whose wall is a component: "
                            : " cavities, whose walls are components: ") +
         rounded_text(filled.volume) + " cubic world units";
}

std::vector<std::string> missing_values_notice(std::span<const float> values,
                                               const std::string& field) {
  const auto missing =
      std::count_if(values.begin(), values.end(), [](float value) { return std::isnan(value); });
  if (missing == 0) return {};
  const auto all = static_cast<std::ptrdiff_t>(values.size());
  const std::string have = "have no value of \"" + field + "\"";
  if (missing == all) {
    return {"All vertices " + have +
            ": it lies elsewhere, if both datasets are in the same world."};
  }
  const double percent = 100 * static_cast<double>(missing) / static_cast<double>(all);
  return {rounded_text(std::ceil(10 * percent) / 10) + " % of the vertices " + have +
          "; they get the color of no_value_color."};
}

std::string not_written_text(const std::string& file) {
  return file + " is not written because the surface is empty; --allow-empty writes it.";
}

std::string not_written_text(std::span<const std::string> names) {
  std::string text = "No file is written for empty surfaces; --allow-empty writes one for ";
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "\"" : ", \"") + names[i] + "\"";
  }
  return text + ".";
}

}  // namespace multitetra

#include "common/request/local_thresholds.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "common/base/enum_names.hpp"
#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<CoordinateSystem, 2> kSystems = {{"world", "index"}};
constexpr EnumNames<Combination, 2> kCombinations = {{"order", "minimum"}};

// Collects faults and keeps the first.
class Faults {
 public:
  void add(ErrorCode code, std::string text) {
    if (!first_) first_ = Error{code, std::move(text)};
  }
  void require(bool holds, const std::string& field, double value, std::string_view rule) {
    if (holds) return;
    add(ErrorCode::kInvalidArgument, "The threshold map's " + field + " is " +
                                         shortest_text(value) + "; it must be " +
                                         std::string(rule) + ".");
  }
  void require(bool holds, const std::string& field, std::string_view rule) {
    if (!holds) {
      add(ErrorCode::kInvalidArgument, "The threshold map's " + field + " " + std::string(rule));
    }
  }
  void threshold(const std::string& field, double value) {
    require(std::isfinite(value) && value >= 0, field, value, "a finite number, 0 or greater");
  }
  void coordinate(const std::string& field, double value) {
    require(std::abs(value) <= kMaxCoordinate, field, value, "a number from -1e100 to 1e100");
  }
  void place(const std::string& field, const Vec3& place) {
    for (const double number : place) coordinate(field, number);
  }
  // Requires a positive length or ratio.
  void positive(const std::string& field, double value) {
    require(value > 0 && value <= kMaxCoordinate, field, value,
            "a number greater than 0 and at most 1e100");
  }

  [[nodiscard]] const std::optional<Error>& first() const { return first_; }

 private:
  std::optional<Error> first_;
};

void check(const BoxShape& box, const std::string& region, Faults& faults) {
  faults.place(region + ".box.low", box.low);
  faults.place(region + ".box.high", box.high);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    faults.require(
        box.low[axis] <= box.high[axis], region + ".box",
        "has a low corner above its high corner; low must be at most high on every axis.");
  }
}

void check(const BallShape& ball, const std::string& region, Faults& faults) {
  faults.place(region + ".ball.center", ball.center);
  faults.require(ball.radius >= 0 && ball.radius <= kMaxCoordinate, region + ".ball.radius",
                 ball.radius, "a number from 0 to 1e100");
}

void check(const HalfSpaceShape& half_space, const std::string& region, Faults& faults) {
  faults.place(region + ".half_space.normal", half_space.normal);
  faults.require(half_space.normal != Vec3{0, 0, 0}, region + ".half_space.normal",
                 "is 0 on all axes; it must have a direction.");
  faults.coordinate(region + ".half_space.offset", half_space.offset);
}

void check(const std::vector<ThresholdRegion>& regions, Faults& faults) {
  if (regions.size() > kMaxThresholdRegions) {
    faults.add(ErrorCode::kLimitExceeded,
               "The threshold map has " + std::to_string(regions.size()) + " regions; at most " +
                   std::to_string(kMaxThresholdRegions) + " are allowed.");
    return;
  }
  for (std::size_t i = 0; i < regions.size() && !faults.first(); ++i) {
    const std::string region = "regions[" + std::to_string(i) + "]";
    std::visit([&](const auto& shape) { check(shape, region, faults); }, regions[i].shape);
    faults.threshold(region + ".threshold", regions[i].threshold);
  }
}

void check(const ThresholdGrid& grid, Faults& faults) {
  std::uint64_t samples = 1;
  for (const std::int32_t side : grid.dims) {
    faults.require(side >= 1, "grid.dims", side, "1 or greater on every axis");
    if (faults.first()) return;
    samples =
        std::min<std::uint64_t>(samples * static_cast<std::uint64_t>(side), kMaxGridThresholds + 1);
  }
  if (std::max<std::uint64_t>(samples, grid.thresholds.size()) > kMaxGridThresholds) {
    faults.add(ErrorCode::kLimitExceeded, "The threshold map's grid has more than " +
                                              std::to_string(kMaxGridThresholds) +
                                              " thresholds; no more are allowed.");
    return;
  }
  faults.require(samples == grid.thresholds.size(), "grid.thresholds",
                 "must have one threshold for each of its samples.");
  for (const Vec3& column : grid.index_to_world.columns)
    faults.place("grid.index_to_world", column);
  faults.place("grid.index_to_world", grid.index_to_world.translation);
  const double volume = grid.index_to_world.determinant();
  faults.require(std::isfinite(volume) && volume != 0, "grid.index_to_world",
                 "has linearly dependent columns; they must be independent.");
  const auto wrong =
      std::find_if(grid.thresholds.begin(), grid.thresholds.end(), [](float threshold) {
        return std::isinf(threshold) || threshold < 0;  // False for NaN.
      });
  if (wrong != grid.thresholds.end()) {
    faults.require(false,
                   "grid.thresholds[" + std::to_string(wrong - grid.thresholds.begin()) + "]",
                   static_cast<double>(*wrong),
                   "a finite number, 0 or greater, or NaN where the grid has no threshold");
  }
}

void check(const Frustum& frustum, const Vec3& eye, Faults& faults) {
  faults.place("view.frustum.look_at", frustum.look_at);
  faults.place("view.frustum.up", frustum.up);
  faults.positive("view.frustum.aspect", frustum.aspect);
  faults.threshold("view.frustum.outside", frustum.outside);
  faults.require(frustum.look_at != eye, "view.frustum.look_at",
                 "is equal to the eye; it must differ.");
  const Vec3 ahead = {frustum.look_at[0] - eye[0], frustum.look_at[1] - eye[1],
                      frustum.look_at[2] - eye[2]};
  faults.require(cross(ahead, frustum.up) != Vec3{0, 0, 0}, "view.frustum.up",
                 "is 0 or parallel to the viewing direction.");
}

void check(const ThresholdView& view, Faults& faults) {
  faults.place("view.eye", view.eye);
  faults.require(view.field_of_view > 0 && view.field_of_view < 180, "view.field_of_view",
                 view.field_of_view, "a number of degrees greater than 0 and less than 180");
  faults.positive("view.height_pixels", view.height_pixels);
  faults.threshold("view.tolerance_pixels", view.tolerance_pixels);
  if (view.frustum) check(*view.frustum, view.eye, faults);
}

}  // namespace

std::string_view name(CoordinateSystem coordinates) { return kSystems.of(coordinates); }
std::string_view name(Combination combination) { return kCombinations.of(combination); }
std::optional<CoordinateSystem> coordinate_system_from(std::string_view name) {
  return kSystems.find(name);
}
std::optional<Combination> combination_from(std::string_view name) {
  return kCombinations.find(name);
}

bool operator==(const ThresholdGrid& a, const ThresholdGrid& b) {
  return a.dims == b.dims && a.index_to_world == b.index_to_world &&
         std::equal(a.thresholds.begin(), a.thresholds.end(), b.thresholds.begin(),
                    b.thresholds.end(), [](float left, float right) {
                      return left == right || (std::isnan(left) && std::isnan(right));
                    });
}

bool operator==(const LocalThresholds& a, const LocalThresholds& b) {
  const bool same_grid = a.grid == b.grid || (a.grid && b.grid && *a.grid == *b.grid);
  return same_grid && std::tie(a.coordinates, a.combination, a.regions, a.view, a.error_floor) ==
                          std::tie(b.coordinates, b.combination, b.regions, b.view, b.error_floor);
}

Result<void> check_thresholds(const LocalThresholds& thresholds) {
  Faults faults;
  check(thresholds.regions, faults);
  if (thresholds.grid) check(*thresholds.grid, faults);
  if (thresholds.view) check(*thresholds.view, faults);
  faults.threshold("at_least", thresholds.error_floor);
  if (faults.first()) return tl::unexpected(*faults.first());
  return {};
}

}  // namespace multitetra

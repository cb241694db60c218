#include "client/load/script.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/base/enum_names.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<ScriptKind, 4> kScripts = {{"random-isovalues", "drag", "roi", "mixed"}};

OpenStream surface(const DatasetInfo& info, double isovalue, double error) {
  return {.dataset = info.name,
          .request = {.isovalue = isovalue, .error = error},
          .cached_tile_digests = {}};
}

}  // namespace

std::optional<ScriptKind> script_kind_from(std::string_view name) { return kScripts.find(name); }

std::string_view name(ScriptKind kind) { return kScripts.of(kind); }

double isovalue(const DatasetInfo& info, int number, int count) {
  const double range = info.max - info.min;
  double low = info.min + 0.25 * range;
  double high = info.min + 0.75 * range;
  if (!info.suggested_isovalues.empty()) {
    const auto [least, greatest] =
        std::minmax_element(info.suggested_isovalues.begin(), info.suggested_isovalues.end());
    low = std::max(*least - 0.02 * range, info.min);
    high = std::min(*greatest + 0.02 * range, info.max);
  }
  return low + (high - low) * (number + 0.5) / count;
}

Script::Script(ScriptKind kind, std::vector<DatasetInfo> datasets, std::uint64_t seed,
               ScriptOptions options)
    : kind_(kind), datasets_(std::move(datasets)), options_(std::move(options)), random_(seed) {
  assert(!datasets_.empty() && !options_.errors.empty() && options_.isovalues > 0);
}

ScriptedRequest Script::next() {
  while (planned_.empty()) plan();
  ScriptedRequest scripted = std::move(planned_.front());
  planned_.pop_front();
  scripted.open.request.simplify = options_.simplify;
  return scripted;
}

void Script::plan() {
  ScriptKind kind = kind_;
  if (kind == ScriptKind::kMixed) kind = static_cast<ScriptKind>(random_index(3));
  if (kind == ScriptKind::kRandomIsovalues) plan_surface();
  if (kind == ScriptKind::kDrag) plan_drag();
  if (kind == ScriptKind::kRegion) plan_region();
}

void Script::plan_surface() {
  const DatasetInfo& info = random_dataset();
  const int number = static_cast<int>(random_index(static_cast<std::size_t>(options_.isovalues)));
  planned_.push_back(
      {.open = surface(info, isovalue(info, number, options_.isovalues), random_error()),
       .replaced_after = std::nullopt,
       .pause = random_pause()});
}

// The slider moves up or down from its position and is released at the end.
void Script::plan_drag() {
  const DatasetInfo& info = random_dataset();
  const double error = random_error();
  const auto positions = static_cast<std::size_t>(options_.isovalues);
  int number = static_cast<int>(random_index(positions));
  int direction = uniform() < 0.5 ? -1 : 1;
  for (int i = 0; i < options_.drag_length; ++i) {
    if (number + direction < 0 || number + direction >= options_.isovalues) direction = -direction;
    number = std::clamp(number + direction, 0, options_.isovalues - 1);
    planned_.push_back({.open = surface(info, isovalue(info, number, options_.isovalues), error),
                        .replaced_after = options_.drag_interval});
  }
  planned_.back().replaced_after.reset();
  planned_.back().pause = random_pause();
}

void Script::plan_region() {
  const DatasetInfo& info = random_dataset();
  const int number = static_cast<int>(random_index(static_cast<std::size_t>(options_.isovalues)));
  const double coarse = *std::max_element(options_.errors.begin(), options_.errors.end());
  OpenStream open = surface(info, isovalue(info, number, options_.isovalues), coarse);
  open.request.thresholds.coordinates = CoordinateSystem::kIndex;
  const double radius = 0.1 * *std::max_element(info.dims.begin(), info.dims.end());
  constexpr int kPlaces = 4;
  // The centers of octants, so that users sometimes request the same regions.
  for (int i = 0; i < kPlaces; ++i) {
    Vec3 center = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      center[axis] = (static_cast<double>(random_index(2)) + 0.5) / 2 * info.dims[axis];
    }
    open.request.thresholds.regions = {
        {.shape = BallShape{.center = center, .radius = radius}, .threshold = coarse / 4}};
    planned_.push_back({.open = open, .replaced_after = std::nullopt, .pause = random_pause()});
  }
}

double Script::uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

std::size_t Script::random_index(std::size_t count) {
  return std::min(static_cast<std::size_t>(uniform() * static_cast<double>(count)), count - 1);
}

// Returns an exponentially distributed pause, as between independent events, at most four means.
std::chrono::milliseconds Script::random_pause() {
  const double factor = std::min(-std::log(1 - uniform()), 4.0);
  return std::chrono::milliseconds(
      static_cast<std::int64_t>(factor * static_cast<double>(options_.mean_pause.count())));
}

}  // namespace multitetra

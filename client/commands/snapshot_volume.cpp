#include "client/commands/snapshot_volume.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "common/base/parse_number.hpp"
#include "common/dataset/tissues.hpp"
#include "common/request/slice_request.hpp"

namespace multitetra {
namespace {

constexpr DisplayWindow kBone = {.low = -500, .high = 1500};  // Hounsfield units.
// Shares of the samples that are not background.
constexpr double kDarker = 0.01;
constexpr double kBrighter = 0.005;
// A background's peak holds at least this share of all samples, within this share of the range from
// its low end.
constexpr double kBackground = 0.15;

using Counts = std::vector<std::uint64_t>;

std::uint64_t sum_from(const Counts& counts, std::size_t first) {
  return std::accumulate(counts.begin() + static_cast<std::ptrdiff_t>(first), counts.end(),
                         std::uint64_t{0});
}

// Returns the number of leading bins that are background: up to the minimum after the peak; 0
// without such a peak.
std::size_t background_bins(const Counts& counts) {
  if (counts.size() < 8) return 0;
  const auto reach =
      static_cast<std::size_t>(std::ceil(kBackground * static_cast<double>(counts.size())));
  const auto peak = std::max_element(counts.begin(), counts.end());
  auto end = static_cast<std::size_t>(peak - counts.begin()) + 1;
  if (end > reach) return 0;
  while (end < reach && counts[end] < counts[end - 1]) ++end;
  const std::uint64_t all = sum_from(counts, 0);
  const std::uint64_t background = all - sum_from(counts, end);
  const bool is_large = static_cast<double>(background) >= kBackground * static_cast<double>(all);
  return is_large && background < all ? end : 0;
}

// Returns the value below which this share of the samples lies, without the first bins.
double percentile(const Histogram& histogram, std::size_t first, double share) {
  const auto& counts = histogram.counts;
  const double width = (histogram.high - histogram.low) / static_cast<double>(counts.size());
  double left = share * static_cast<double>(sum_from(counts, first));
  for (std::size_t bin = first; bin < counts.size(); ++bin) {
    const auto count = static_cast<double>(counts[bin]);
    if (count > 0 && left <= count)
      return histogram.low + (static_cast<double>(bin) + left / count) * width;
    left -= count;
  }
  return histogram.high;
}

// Returns the step along each axis with which at most `limit` samples are drawn.
std::uint64_t step_for(const DatasetInfo& info, std::uint64_t limit) {
  std::uint64_t step = 1;
  const auto samples = [&] {
    double product = 1;
    for (const auto count : info.dims)
      product *= std::floor(static_cast<double>(count - 1) / static_cast<double>(step)) + 1;
    return product;
  };
  while (samples() > static_cast<double>(limit) && step < 1024) step *= 2;
  return step;
}

}  // namespace

Result<std::vector<OpacityPoint>> parse_opacities(std::string_view text) {
  std::vector<OpacityPoint> points;
  for (const std::string_view part : split(text, ',')) {
    const auto pair = parse_numbers<double>(part, 2, ':');
    const bool is_valid =
        pair && std::isfinite(pair->front()) && pair->back() >= 0 && pair->back() <= 1;
    if (!is_valid || (!points.empty() && pair->front() < points.back().value)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--opacities: \"" + std::string(part) +
                      "\" is not a value with its opacity; write for example 150:0,400:0.1, by "
                      "ascending value, with opacities from 0 to 1.");
    }
    points.push_back({.value = pair->front(), .opacity = pair->back()});
  }
  return points;
}

std::vector<OpacityPoint> usual_opacities(const DatasetInfo& info) {
  if (is_ct(info)) return {{150, 0}, {350, 0.08}, {1200, 0.5}};
  const DisplayWindow window = usual_window(info);
  const auto at = [&](double share) { return window.low + share * (window.high - window.low); };
  return {{at(0.1), 0}, {at(0.4), 0.01}, {at(0.9), 0.12}};
}

DisplayWindow usual_window(const DatasetInfo& info) {
  if (is_ct(info)) return kBone;
  if (info.display_window) return *info.display_window;
  const std::size_t first = background_bins(info.histogram.counts);
  const DisplayWindow most = {.low = percentile(info.histogram, first, kDarker),
                              .high = percentile(info.histogram, first, 1 - kBrighter)};
  return is_valid(most) ? most : DisplayWindow{.low = info.min, .high = info.max};
}

void add_volume_options(Command& command, VolumeArguments& a) {
  command.begin_group("Volume");
  command
      .add_option("--volume", a.mode,
                  "on: draw the samples as a volume, together with the surfaces of --isovalue; "
                  "maximum: the largest value behind each pixel")
      ->one_of({"off", "on", "maximum"})
      ->capture_default_str();
  command
      .add_option(
          "--opacities", a.opacities,
          "Opacity of one voxel by ascending value, linear between them, as in the viewer's "
          "addresses (default: bone of a CT, else a faint ramp over most values)")
      ->type_name("VALUE:OPACITY,...");
  command
      .add_option(
          "--volume-window", a.window,
          "Values of the darkest and the brightest color (default: -500,1500 for a CT, else "
          "the file's window or most values)")
      ->delimiter(',')
      ->type_name("LOW,HIGH");
  command.add_option("--volume-colors", a.map, "Colors of the volume by value")
      ->one_of({"gray", "viridis", "cividis", "coolwarm"})
      ->capture_default_str();
  command.add_flag("--no-volume-shading", a.is_unlit, "Do not light the volume by its gradient");
  command
      .add_option(
          "--volume-samples", a.samples,
          "Samples to fetch at most, 4 bytes each; larger volumes are drawn from every 2nd, "
          "4th ... along each axis")
      ->within(std::uint64_t{1000}, std::uint64_t{1} << 33)
      ->capture_default_str();
}

Result<void> check(const VolumeArguments& arguments) {
  if (!arguments.opacities.empty()) {
    if (const auto points = parse_opacities(arguments.opacities); !points) {
      return tl::unexpected(points.error());
    }
  }
  const std::vector<double>& window = arguments.window;
  const bool is_window = window.size() == 2 && is_valid({.low = window[0], .high = window[1]});
  if (window.empty() || is_window) return {};
  return fail(ErrorCode::kInvalidArgument,
              "--volume-window takes two values, the lower one first, such as -160,240.");
}

ClientResult<FetchedVolume> fetched_volume(const VolumeArguments& arguments, Client& client,
                                           const DatasetInfo& info, const Affine& to_output) {
  const auto refuse = [](const Error& error) { return fail(ErrorSource::kCheck, error); };
  FetchedVolume fetched{.drawn = {}, .step = step_for(info, arguments.samples)};
  DrawnVolume& volume = fetched.drawn;
  volume.is_maximum = arguments.mode == "maximum";
  volume.is_lit = !arguments.is_unlit;
  volume.opacities = arguments.opacities.empty() ? usual_opacities(info)
                                                 : parse_opacities(arguments.opacities).value();
  DisplayWindow window = usual_window(info);
  if (!arguments.window.empty()) window = {.low = arguments.window[0], .high = arguments.window[1]};
  volume.colors = {
      .map = color_map_from(arguments.map).value(), .low = window.low, .high = window.high};

  const auto step = static_cast<double>(fetched.step);
  volume.to_world = to_output;
  for (Vec3& column : volume.to_world.columns) column = scaled(column, step);
  volume.voxel = length(volume.to_world.columns[0]) / step;
  for (const Vec3& column : volume.to_world.columns)
    volume.voxel = std::min(volume.voxel, length(column) / step);
  std::array<std::uint32_t, 3> counts{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    counts[axis] =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(info.dims[axis] - 1) / fetched.step) +
        1;
    volume.counts[axis] = counts[axis];
    if (counts[axis] < 2) {
      return refuse({ErrorCode::kLimitExceeded, "--volume-samples is too small for this dataset."});
    }
  }
  const auto [width, height, depth] = counts;
  volume.values.resize(std::size_t{width} * height * depth);
  auto* to = volume.values.data();
  const std::uint32_t rows = std::min(height, kMaxSlicePixels / width);
  const std::uint32_t layers =
      rows < height ? 1 : std::min(depth, kMaxSlicePixels / (width * height));
  for (std::uint32_t z = 0; z < depth; z += layers) {
    for (std::uint32_t y = 0; y < height; y += rows) {
      const SliceRequest box = {.coordinates = CoordinateSystem::kIndex,
                                .origin = {0, y * step, z * step},
                                .right = {step, 0, 0},
                                .down = {0, step, 0},
                                .inward = {0, 0, step},
                                .width = width,
                                .height = std::min(rows, height - y),
                                .layers = std::min(layers, depth - z),
                                .interpolation = Interpolation::kNearest,
                                .detail = SliceDetail::kFull};
      const auto reply = client.slice(info.name, box);
      if (!reply) return tl::unexpected(reply.error());
      if (reply->packed_type || reply->values->size() != box.pixels() * sizeof(float)) {
        return refuse({ErrorCode::kDamagedData, "The received box of samples has another size."});
      }
      std::memcpy(to, reply->values->data(), reply->values->size());
      to += box.pixels();
    }
  }
  return fetched;
}

}  // namespace multitetra

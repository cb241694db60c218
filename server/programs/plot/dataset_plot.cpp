#include "server/programs/plot/dataset_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "common/base/number_at_resolution.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "server/programs/plot/svg.hpp"

namespace multitetra {
namespace {

constexpr double kWidth = 960;
constexpr double kHeight = 720;
constexpr double kLeft = 84;
constexpr double kRight = 800;  // The legend is to the right of it.
constexpr std::string_view kInk = "#333d49";
constexpr std::string_view kQuiet = "#66717e";
constexpr std::string_view kGrid = "#e3e7ec";
constexpr std::string_view kSamples = "#8fa6bd";
constexpr std::string_view kMark = "#b8691b";
// From few triangles to many, also distinguishable by lightness.
constexpr std::array<std::string_view, 8> kCurves = {"#3b1f6b", "#31508f", "#1f7f86", "#3aa655",
                                                     "#b5b12a", "#dd7f2e", "#c23b3b", "#7a7a7a"};

// The position and ranges of one of the two plots.
struct Frame {
  double top = 0;
  double bottom = 0;
  double low = 0;  // Abscissa.
  double high = 1;
  double least = 1;  // Ordinate, logarithmic; powers of ten.
  double most = 10;

  [[nodiscard]] double x(double value) const {
    return kLeft + (kRight - kLeft) * (value - low) / (high - low);
  }
  [[nodiscard]] double y(double count) const {
    const double share = std::log(std::max(count, least) / least) / std::log(most / least);
    return bottom - (bottom - top) * std::min(1.0, share);
  }
};

std::string count_text(double count) {
  if (count >= 1e9) return human_number(count / 1e9) + " G";
  if (count >= 1e6) return human_number(count / 1e6) + " M";
  return count >= 1e3 ? human_number(count / 1e3) + " k" : human_number(count);
}

// Returns 1, 2 or 5 times a power of ten, for about six ticks.
double tick_distance(double range) {
  const double rough = range / 6;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * power >= rough) return step * power;
  }
  return 10 * power;
}

void draw_axes(Svg& svg, const Frame& frame, std::string_view ordinate) {
  for (double count = frame.least; count <= frame.most * 1.001; count *= 10) {
    svg.line(kLeft, frame.y(count), kRight, frame.y(count), kGrid, 1);
    svg.text(kLeft - 8, frame.y(count) + 4, count_text(count),
             {.size = 12, .color = kQuiet, .anchor = Svg::Anchor::kEnd});
  }
  const double step = tick_distance(frame.high - frame.low);
  for (double tick = std::ceil(frame.low / step); tick * step <= frame.high; ++tick) {
    const double x = frame.x(tick * step);
    svg.line(x, frame.bottom, x, frame.bottom + 5, kQuiet, 1);
    svg.text(x, frame.bottom + 20, number_at(tick * step, step / 10),
             {.size = 12, .color = kQuiet, .anchor = Svg::Anchor::kMiddle});
  }
  svg.line(kLeft, frame.bottom, kRight, frame.bottom, kQuiet, 1);
  svg.text(24, (frame.top + frame.bottom) / 2, ordinate,
           {.color = kInk, .anchor = Svg::Anchor::kMiddle, .is_upwards = true});
}

double next_power(double count) {
  return std::pow(10, std::ceil(std::log10(std::max(count, 2.0))));
}

void draw_histogram(Svg& svg, const Frame& frame, const Histogram& histogram) {
  const auto bins = static_cast<double>(histogram.counts.size());
  Svg::Points outline = {{frame.x(histogram.low), frame.bottom}};
  for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    const auto count = static_cast<double>(histogram.counts[bin]);
    const double y = count > 0 ? frame.y(count) : frame.bottom;
    const double width = (histogram.high - histogram.low) / bins;
    const double x = histogram.low + width * static_cast<double>(bin);
    outline.emplace_back(frame.x(x), y);
    outline.emplace_back(frame.x(x + width), y);
  }
  outline.emplace_back(frame.x(histogram.high), frame.bottom);
  svg.area(outline, kSamples);
}

void draw_curve(Svg& svg, const Frame& frame, const SizeCurves& curves, std::size_t number) {
  const std::string_view color = kCurves[number % kCurves.size()];
  Svg::Points points;
  for (std::size_t i = 0; i < curves.isovalues.size(); ++i) {
    points.emplace_back(frame.x(curves.isovalues[i]), frame.y(curves.triangles[number][i]));
  }
  svg.polyline(points, color, 2);
  const double y = frame.top + 34 + 22 * static_cast<double>(number);
  svg.line(kRight + 18, y - 4, kRight + 42, y - 4, color, 3);
  const double error = curves.errors[number];
  svg.text(kRight + 50, y, human_number(error) + (error == 1 ? " voxel" : " voxels"), {});
}

void draw_suggestions(Svg& svg, const Frame& above, const Frame& below, const DatasetInfo& info) {
  std::vector<double> sorted = info.suggested_isovalues;
  std::sort(sorted.begin(), sorted.end());
  double free_from = 0;  // Left end of the free space in the lower row of labels.
  for (const double isovalue : sorted) {
    const double x = above.x(isovalue);
    svg.line(x, above.top - 6, x, below.bottom, kMark, 1.2, "4 4");
    const double y = x < free_from ? above.top - 24 : above.top - 10;
    svg.text(x, y, human_value(isovalue, info),
             {.size = 12, .color = kMark, .anchor = Svg::Anchor::kMiddle});
    if (x >= free_from) free_from = x + 48;
  }
}

std::string facts(const DatasetInfo& info) {
  return sides_text(info.dims) + " samples of type " + std::string(name(info.type)) +
         ", 1 voxel is " + human_number(voxel_length(info)) +
         (voxel_length(info) == 1 ? " world unit" : " world units");
}

}  // namespace

std::string dataset_plot(const DatasetInfo& info, const SizeCurves& curves) {
  const Histogram& histogram = info.histogram;
  double most_samples = 1;
  for (const std::uint64_t count : histogram.counts) {
    most_samples = std::max(most_samples, static_cast<double>(count));
  }
  double most_triangles = 1;
  double least_triangles = 1e12;
  for (const auto& curve : curves.triangles) {
    for (const double count : curve) {
      most_triangles = std::max(most_triangles, count);
      if (count >= 1) least_triangles = std::min(least_triangles, count);
    }
  }
  const double low = std::min(info.min, histogram.low);
  const double high = std::max(info.max, histogram.high);
  const double end = high > low ? high : low + 1;
  const Frame above = {.top = 108,
                       .bottom = 300,
                       .low = low,
                       .high = end,
                       .least = 1,
                       .most = next_power(most_samples)};
  Frame below = {.top = 372,
                 .bottom = 640,
                 .low = low,
                 .high = end,
                 .least = 1,
                 .most = next_power(most_triangles)};
  // Limits the range, so that surfaces of few triangles at the ends take no space.
  below.least =
      std::max(std::pow(10, std::floor(std::log10(std::min(least_triangles, most_triangles)))),
               below.most / 1e5);

  Svg svg(kWidth, kHeight);
  svg.text(kLeft, 36, info.name, {.size = 20, .is_bold = true});
  svg.text(kLeft, 58, facts(info), {.size = 13, .color = kQuiet});
  draw_axes(svg, above, "samples in a bin");
  draw_histogram(svg, above, histogram);
  draw_axes(svg, below, "triangles of the surface");
  svg.text(kRight + 18, below.top + 8, "allowed error", {.is_bold = true});
  for (std::size_t number = 0; number < curves.errors.size(); ++number) {
    draw_curve(svg, below, curves, number);
  }
  draw_suggestions(svg, above, below, info);
  svg.text(kRight + 18, above.top + 8, "suggested", {.color = kMark, .is_bold = true});
  svg.text(kRight + 18, above.top + 26, "isovalues", {.color = kMark, .is_bold = true});
  svg.text((kLeft + kRight) / 2, below.bottom + 44, "isovalue", {.anchor = Svg::Anchor::kMiddle});
  svg.text(kLeft, kHeight - 14,
           "Triangles are estimated from the error spectrum; certified bound, exact topology.",
           {.size = 11.5, .color = kQuiet});
  return svg.file("The values of " + info.name + " and the sizes of their surfaces");
}

}  // namespace multitetra

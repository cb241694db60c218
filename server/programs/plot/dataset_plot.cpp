#include "server/programs/plot/dataset_plot.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/number_at_resolution.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"

namespace multitetra {
namespace {

constexpr double kLeft = 84;
constexpr double kRight = 800;  // The legend is to the right of it.
constexpr Rgb kInk = {51, 61, 73};
constexpr Rgb kQuiet = {102, 113, 126};
constexpr Rgb kGrid = {227, 231, 236};
constexpr Rgb kSamples = {143, 166, 189};
constexpr Rgb kMark = {184, 105, 27};
// From few triangles to many, also distinguishable by lightness.
constexpr Rgb kCurves[] = {{59, 31, 107},  {49, 80, 143},  {31, 127, 134}, {58, 166, 85},
                           {181, 177, 42}, {221, 127, 46}, {194, 59, 59},  {122, 122, 122}};

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

void draw_line(Canvas& canvas, Canvas::Place from, Canvas::Place to, Rgb color, double width,
               std::span<const double> dashes = {}) {
  const Canvas::Place ends[] = {from, to};
  canvas.line(ends, color, width, dashes);
}

void draw_axes(Canvas& canvas, const Frame& frame, std::string_view ordinate) {
  for (double count = frame.least; count <= frame.most * 1.001; count *= 10) {
    draw_line(canvas, {kLeft, frame.y(count)}, {kRight, frame.y(count)}, kGrid, 1);
    canvas.text({kLeft - 8, frame.y(count) + 4}, count_text(count),
                {.size = 12, .color = kQuiet, .anchor = Canvas::Anchor::kEnd});
  }
  const double step = tick_distance(frame.high - frame.low);
  for (double tick = std::ceil(frame.low / step); tick * step <= frame.high; ++tick) {
    const double x = frame.x(tick * step);
    draw_line(canvas, {x, frame.bottom}, {x, frame.bottom + 5}, kQuiet, 1);
    canvas.text({x, frame.bottom + 20}, number_at(tick * step, step / 10),
                {.size = 12, .color = kQuiet, .anchor = Canvas::Anchor::kMiddle});
  }
  draw_line(canvas, {kLeft, frame.bottom}, {kRight, frame.bottom}, kQuiet, 1);
  canvas.text({24, (frame.top + frame.bottom) / 2}, ordinate,
              {.color = kInk, .anchor = Canvas::Anchor::kMiddle, .is_upwards = true});
}

double next_power(double count) {
  return std::pow(10, std::ceil(std::log10(std::max(count, 2.0))));
}

void draw_histogram(Canvas& canvas, const Frame& frame, const Histogram& histogram) {
  const auto bins = static_cast<double>(histogram.counts.size());
  std::vector<Canvas::Place> outline = {{frame.x(histogram.low), frame.bottom}};
  for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    const auto count = static_cast<double>(histogram.counts[bin]);
    const double y = count > 0 ? frame.y(count) : frame.bottom;
    const double width = (histogram.high - histogram.low) / bins;
    const double x = histogram.low + width * static_cast<double>(bin);
    outline.push_back({frame.x(x), y});
    outline.push_back({frame.x(x + width), y});
  }
  outline.push_back({frame.x(histogram.high), frame.bottom});
  canvas.area(outline, kSamples);
}

void draw_curve(Canvas& canvas, const Frame& frame, const SizeCurves& curves, std::size_t number) {
  const Rgb color = kCurves[number % std::size(kCurves)];
  std::vector<Canvas::Place> points;
  for (std::size_t i = 0; i < curves.isovalues.size(); ++i) {
    points.push_back({frame.x(curves.isovalues[i]), frame.y(curves.triangles[number][i])});
  }
  canvas.line(points, color, 2);
  const double y = frame.top + 34 + 22 * static_cast<double>(number);
  draw_line(canvas, {kRight + 18, y - 4}, {kRight + 42, y - 4}, color, 3);
  const double error = curves.errors[number];
  canvas.text({kRight + 50, y}, human_number(error) + (error == 1 ? " voxel" : " voxels"), {});
}

void draw_suggestions(Canvas& canvas, const Frame& above, const Frame& below,
                      const DatasetInfo& info) {
  std::vector<double> sorted = info.suggested_isovalues;
  std::sort(sorted.begin(), sorted.end());
  constexpr double kDashes[] = {4, 4};
  double free_from = 0;  // Left end of the free space in the lower row of labels.
  for (const double isovalue : sorted) {
    const double x = above.x(isovalue);
    draw_line(canvas, {x, above.top - 6}, {x, below.bottom}, kMark, 1.2, kDashes);
    const double y = x < free_from ? above.top - 24 : above.top - 10;
    canvas.text({x, y}, human_value(isovalue, info),
                {.size = 12, .color = kMark, .anchor = Canvas::Anchor::kMiddle});
    if (x >= free_from) free_from = x + 48;
  }
}

std::string facts(const DatasetInfo& info) {
  return sides_text(info.dims) + " samples of type " + std::string(name(info.type)) +
         ", 1 voxel is " + human_number(voxel_length(info)) +
         (voxel_length(info) == 1 ? " world unit" : " world units");
}

}  // namespace

void draw_dataset_plot(Canvas& canvas, const DatasetInfo& info, const SizeCurves& curves) {
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

  canvas.text({kLeft, 36}, info.name, {.size = 20, .is_bold = true});
  canvas.text({kLeft, 58}, facts(info), {.size = 13, .color = kQuiet});
  draw_axes(canvas, above, "samples in a bin");
  draw_histogram(canvas, above, histogram);
  draw_axes(canvas, below, "triangles of the surface");
  canvas.text({kRight + 18, below.top + 8}, "allowed error", {.is_bold = true});
  for (std::size_t number = 0; number < curves.errors.size(); ++number) {
    draw_curve(canvas, below, curves, number);
  }
  draw_suggestions(canvas, above, below, info);
  canvas.text({kRight + 18, above.top + 8}, "suggested", {.color = kMark, .is_bold = true});
  canvas.text({kRight + 18, above.top + 26}, "isovalues", {.color = kMark, .is_bold = true});
  canvas.text({(kLeft + kRight) / 2, below.bottom + 44}, "isovalue",
              {.anchor = Canvas::Anchor::kMiddle});
  canvas.text({kLeft, kPlotHeight - 14},
              "Triangles are estimated from the error spectrum; certified bound, exact topology.",
              {.size = 11.5, .color = kQuiet});
}

}  // namespace multitetra

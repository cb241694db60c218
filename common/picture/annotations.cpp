#include "common/picture/annotations.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/number_at_resolution.hpp"
#include "common/base/number_text.hpp"
#include "common/picture/canvas.hpp"

namespace multitetra {
namespace {

struct Inks {
  Rgb ink;
  Rgb rim;
};

Inks inks_on(Background background) {
  if (background == Background::kDark) return {.ink = {230, 235, 240}, .rim = {18, 22, 28}};
  return {.ink = {28, 33, 40}, .rim = {255, 255, 255}};
}

// Sizes are for pictures whose shorter side has 720 pixels; text in smaller ones stays legible.
double magnification(int width, int height) {
  return std::max(0.6, std::min(width, height) / 720.0);
}

constexpr double kMargin = 16;
constexpr double kLetter = 13.5;  // The size of letters.

Canvas::TextStyle letters(double size, const Inks& inks) {
  return {.size = size, .color = inks.ink, .rim = inks.rim};
}

}  // namespace

ScaleLength scale_length(const Camera& camera) {
  const double unit = camera.distance / camera.pixels_at_one;  // World units of a pixel.
  const double wanted = 110 * magnification(camera.width, camera.height) * unit;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  double world = decade;
  for (const double digit : {2.0, 5.0}) {
    if (digit * decade <= wanted) world = digit * decade;
  }
  return {.world = world, .pixels = world / unit};
}

void draw_scale_bar(Picture& picture, const Camera& camera, const std::string& unit,
                    Background background) {
  const auto [world, pixels] = scale_length(camera);
  const double m = magnification(picture.width, picture.height);
  const Inks inks = inks_on(background);
  const double right = picture.width - kMargin * m;
  const double left = right - pixels;
  const double middle = picture.height - (kMargin + 4) * m;
  const Canvas::Place bar[] = {{left, middle - 4 * m},  {left, middle + 4 * m},
                               {left, middle},          {right, middle},
                               {right, middle - 4 * m}, {right, middle + 4 * m}};
  Canvas canvas(picture);
  canvas.line(bar, inks.rim, 4.5 * m);
  canvas.line(bar, inks.ink, 1.5 * m);
  const std::string text = rounded_text(world) + " " +
                           (!unit.empty() ? unit
                            : world == 1  ? "unit"
                                          : "units");
  // Centered, but within the margin.
  const Canvas::TextStyle style = letters(kLetter * m, inks);
  const double width = canvas.text_width(text, style);
  canvas.text({std::min((left + right - width) / 2, right - width), middle - 9 * m}, text, style);
}

void draw_legend(Picture& picture, const Legend& legend, Background background) {
  const double m = magnification(picture.width, picture.height);
  const Inks inks = inks_on(background);
  const double length = std::min(200 * m, picture.width / 2.0 - kMargin * m);
  const double left = kMargin * m;
  const double bottom = picture.height - kMargin * m;
  const int top = std::max(0, static_cast<int>(bottom - 28 * m));
  for (int y = top; y < std::min<double>(picture.height, top + 11 * m); ++y) {
    for (int x = static_cast<int>(left); x < std::min<double>(picture.width, left + length); ++x) {
      const Rgb color = color_at(legend.scale.map, (x + 0.5 - left) / length);
      picture.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                     static_cast<std::size_t>(x)] = {color[0], color[1], color[2], 255};
    }
  }
  Canvas canvas(picture);
  const Canvas::TextStyle style = letters(kLetter * m, inks);
  const double resolution = 1e-4 * (legend.scale.high - legend.scale.low);
  const std::string high =
      number_at(legend.scale.high, resolution) + (legend.unit.empty() ? "" : " " + legend.unit);
  canvas.text({left, bottom - m}, number_at(legend.scale.low, resolution), style);
  canvas.text({std::max(left, left + length - canvas.text_width(high, style)), bottom - m}, high,
              style);
  const std::string name = legend.name + (legend.scale.is_logarithmic ? ", logarithmic" : "");
  canvas.text({left, top - 6 * m}, name, style);
}

}  // namespace multitetra

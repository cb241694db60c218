#include "common/picture/annotations.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/number_at_resolution.hpp"
#include "common/base/number_text.hpp"
#include "common/picture/lettering.hpp"

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
constexpr double kLetter = 10;  // The height of a capital.

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
  const auto [ink, rim] = inks_on(background);
  const double right = picture.width - kMargin * m;
  const double left = right - pixels;
  const double middle = picture.height - (kMargin + 4) * m;
  const Stroke strokes[] = {{.from = {left, middle}, .to = {right, middle}},
                            {.from = {left, middle - 4 * m}, .to = {left, middle + 4 * m}},
                            {.from = {right, middle - 4 * m}, .to = {right, middle + 4 * m}}};
  draw_strokes(picture, strokes, 4.5 * m, rim);
  draw_strokes(picture, strokes, 1.5 * m, ink);
  const std::string text = rounded_text(world) + " " +
                           (!unit.empty() ? unit
                            : world == 1  ? "unit"
                                          : "units");
  // Centered, but within the margin.
  const double width = text_width(text, kLetter * m);
  draw_text(picture, text, std::min((left + right - width) / 2, right - width), middle - 9 * m,
            kLetter * m, ink, rim);
}

void draw_legend(Picture& picture, const Legend& legend, Background background) {
  const double m = magnification(picture.width, picture.height);
  const auto [ink, rim] = inks_on(background);
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
  const double letter = kLetter * m;
  const double resolution = 1e-4 * (legend.scale.high - legend.scale.low);
  const std::string high =
      number_at(legend.scale.high, resolution) + (legend.unit.empty() ? "" : " " + legend.unit);
  draw_text(picture, number_at(legend.scale.low, resolution), left, bottom - m, letter, ink, rim);
  draw_text(picture, high, std::max(left, left + length - text_width(high, letter)), bottom - m,
            letter, ink, rim);
  const std::string name = legend.name + (legend.scale.is_logarithmic ? ", logarithmic" : "");
  draw_text(picture, name, left, top - 6 * m, letter, ink, rim);
}

}  // namespace multitetra

// Draws lines, areas and text with Cairo and Pango, on a picture or as a file. Text has the fonts
// of the machine, which have most scripts.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/image/picture.hpp"
#include "common/image/srgb.hpp"

namespace multitetra {

// Places and lengths are in pixels, from the upper left corner.
class Canvas {
 public:
  struct Place {
    double x = 0;
    double y = 0;
  };
  enum class Anchor { kStart, kMiddle, kEnd };
  struct TextStyle {
    double size = 13;
    Rgb color = {51, 61, 73};
    Anchor anchor = Anchor::kStart;
    bool is_bold = false;
    bool is_upwards = false;  // Rotated by 90 degrees, reading upwards.
    // Surrounds the letters, which are then legible on any background.
    std::optional<Rgb> rim = {};
  };

  // Draws on top of the picture, which must outlive the canvas and is complete after it. A pixel of
  // the canvas has `scale` x `scale` pixels of the picture.
  explicit Canvas(Picture& picture, double scale = 1);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  // Joins the places with round corners. `dashes`: lengths of dashes and gaps; empty: solid.
  void line(std::span<const Place> places, Rgb color, double width,
            std::span<const double> dashes = {});
  void area(std::span<const Place> outline, Rgb color);
  // Draws a line of text on the baseline at `at`.
  void text(Place at, std::string_view words, const TextStyle& style);
  [[nodiscard]] double text_width(std::string_view words, const TextStyle& style) const;

 private:
  struct Target;
  explicit Canvas(std::unique_ptr<Target> target);
  friend std::string drawing(std::string_view, int, int, const std::function<void(Canvas&)>&);

  std::unique_ptr<Target> target_;
};

// The suffixes of files that drawing() makes.
inline constexpr std::string_view kDrawingSuffixes[] = {".svg", ".pdf", ".png"};

// Returns a file with what `draw` draws on white, in the format of a suffix of kDrawingSuffixes. A
// PNG has twice the pixels each way. Throws std::runtime_error if it cannot be made, for example
// when memory runs out.
[[nodiscard]] std::string drawing(std::string_view suffix, int width, int height,
                                  const std::function<void(Canvas&)>& draw);

}  // namespace multitetra

// Draws lines, areas and text as SVG.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace multitetra {

class Svg {
 public:
  using Points = std::vector<std::pair<double, double>>;
  enum class Anchor { kStart, kMiddle, kEnd };
  struct TextStyle {
    double size = 13;
    std::string_view color = "#333d49";
    Anchor anchor = Anchor::kStart;
    bool is_bold = false;
    bool is_upwards = false;  // Rotated by 90 degrees, reading upwards.
  };

  // Makes a white image; lengths are pixels at its natural size.
  Svg(double width, double height);

  void line(double x0, double y0, double x1, double y1, std::string_view color, double width,
            std::string_view dashes = {});
  void polyline(const Points& points, std::string_view color, double width);
  void area(const Points& outline, std::string_view color);
  // Draws any text: escapes XML, and drops control characters.
  void text(double x, double y, std::string_view words, const TextStyle& style);

  // Returns the complete file. Browsers and screen readers show `title`.
  [[nodiscard]] std::string file(std::string_view title) const;

 private:
  double width_;
  double height_;
  std::string body_;
};

}  // namespace multitetra

// A drawing of lines, areas and words as SVG text.
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
    bool is_upwards = false;  // Turned by a quarter, read from below.
  };

  // On a white ground; lengths are pixels where it is shown as it is.
  Svg(double width, double height);

  void line(double x0, double y0, double x1, double y1, std::string_view color, double width,
            std::string_view dashes = {});
  void polyline(const Points& points, std::string_view color, double width);
  void area(const Points& outline, std::string_view color);
  // Any text: what means something in XML is escaped, control characters are left out.
  void text(double x, double y, std::string_view words, const TextStyle& style);

  // The whole file. `title` is shown by browsers and screen readers.
  [[nodiscard]] std::string file(std::string_view title) const;

 private:
  double width_;
  double height_;
  std::string body_;
};

}  // namespace multitetra

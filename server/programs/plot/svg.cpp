#include "server/programs/plot/svg.hpp"

#include <array>
#include <cstdio>

namespace multitetra {
namespace {

// Formats to hundredths of a pixel.
std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", value);
  return text.data();
}

std::string escaped(std::string_view words) {
  std::string text;
  for (const char c : words) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '>':
        text += "&gt;";
        break;
      case '"':
        text += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) text += c;
    }
  }
  return text;
}

std::string joined(const Svg::Points& points) {
  std::string text;
  for (const auto& [x, y] : points) text += number(x) + "," + number(y) + " ";
  return text;
}

const char* anchor_word(Svg::Anchor anchor) {
  if (anchor == Svg::Anchor::kMiddle) return "middle";
  return anchor == Svg::Anchor::kEnd ? "end" : "start";
}

}  // namespace

Svg::Svg(double width, double height) : width_(width), height_(height) {}

void Svg::line(double x0, double y0, double x1, double y1, std::string_view color, double width,
               std::string_view dashes) {
  body_ += "<line x1=\"" + number(x0) + "\" y1=\"" + number(y0) + "\" x2=\"" + number(x1) +
           "\" y2=\"" + number(y1) + "\" stroke=\"" + std::string(color) + "\" stroke-width=\"" +
           number(width) + "\"" +
           (dashes.empty() ? "" : " stroke-dasharray=\"" + std::string(dashes) + "\"") + "/>\n";
}

void Svg::polyline(const Points& points, std::string_view color, double width) {
  body_ += "<polyline points=\"" + joined(points) + "\" fill=\"none\" stroke=\"" +
           std::string(color) + "\" stroke-width=\"" + number(width) +
           "\" stroke-linejoin=\"round\"/>\n";
}

void Svg::area(const Points& outline, std::string_view color) {
  body_ += "<polygon points=\"" + joined(outline) + "\" fill=\"" + std::string(color) + "\"/>\n";
}

void Svg::text(double x, double y, std::string_view words, const TextStyle& style) {
  const std::string turn =
      style.is_upwards ? " transform=\"rotate(-90 " + number(x) + " " + number(y) + ")\"" : "";
  body_ += "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" font-size=\"" +
           number(style.size) + "\" fill=\"" + std::string(style.color) + "\" text-anchor=\"" +
           anchor_word(style.anchor) + "\"" + (style.is_bold ? " font-weight=\"600\"" : "") + turn +
           ">" + escaped(words) + "</text>\n";
}

std::string Svg::file(std::string_view title) const {
  const std::string size = number(width_) + "\" height=\"" + number(height_);
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
         size + "\" viewBox=\"0 0 " + number(width_) + " " + number(height_) +
         "\" font-family=\"system-ui, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif\" "
         "role=\"img\">\n<title>" +
         escaped(title) + "</title>\n<rect width=\"" + size + "\" fill=\"#ffffff\"/>\n" + body_ +
         "</svg>\n";
}

}  // namespace multitetra

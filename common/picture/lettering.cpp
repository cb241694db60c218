#include "common/picture/lettering.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace multitetra {
namespace {

struct Glyph {
  char character;
  // Polylines separated by spaces; two digits per corner: x from the left, y from below.
  std::string_view lines;
};

// The glyphs on a grid of 5 x 9: capitals from y = 2 (the baseline) to 8, small letters to 6,
// descenders from 0.
constexpr Glyph kGlyphs[] = {
    {'0', "120307183847433212"},
    {'1', "172822 1232"},
    {'2',
     "071838474602"
     "42"},
    {'3',
     "07183847463544433212"
     "03 1535"},
    {'4', "32380444"},
    {'5',
     "4808053544433212"
     "03"},
    {'6',
     "4738180703123243443515"
     "04"},
    {'7', "084812"},
    {'8',
     "150607183847463515040312324344"
     "35"},
    {'9',
     "0312324347381807061535"
     "46"},
    {'A', "022842 1434"},
    {'B', "02083847463505 3544433202"},
    {'C', "4738180703123243"},
    {'D',
     "020828464422"
     "02"},
    {'E', "48080242 0535"},
    {'F', "480802 0535"},
    {'G', "47381807031232434525"},
    {'H', "0208 4248 0545"},
    {'I', "1232 1838 2228"},
    {'J', "3833221203"},
    {'K', "0208 480542"},
    {'L', "080242"},
    {'M', "0208254842"},
    {'N', "02084248"},
    {'O', "120307183847433212"},
    {'P', "02083847463505"},
    {'Q', "120307183847433212 2442"},
    {'R', "02083847463505 2542"},
    {'S', "473818070615354443321203"},
    {'T', "0848 2228"},
    {'U', "080312324348"},
    {'V', "082248"},
    {'W', "0812263248"},
    {'X', "0248 0842"},
    {'Y', "082548 2522"},
    {'Z', "08480242"},
    {'a', "4642 4536160503123243"},
    {'b', "0802 0516364543321203"},
    {'c', "4536160503123243"},
    {'d', "4842 4536160503123243"},
    {'e', "04444536160503123243"},
    {'f', "382722 1636"},
    {'g',
     "4641301001 45361605041333"
     "44"},
    {'h',
     "0802 05163645"
     "42"},
    {'i', "2622 2828"},
    {'j', "262110 2828"},
    {'k', "0802 360442"},
    {'l', "282332"},
    {'m',
     "0602 05162522 253645"
     "42"},
    {'n',
     "0602 05163645"
     "42"},
    {'o', "120305163645433212"},
    {'p', "0600 0516364543321203"},
    {'q', "4640 4536160503123243"},
    {'r', "0602 042636"},
    {'s',
     "46160514344332"
     "02"},
    {'t', "282332 1636"},
    {'u', "0603123243 4642"},
    {'v', "062246"},
    {'w', "0612253246"},
    {'x', "0246 0642"},
    {'y', "0622 462210"},
    {'z', "06460242"},
    {'.', "2222"},
    {',', "222311"},
    {':', "2323 2626"},
    {'-', "0545"},
    {'+', "0545 2327"},
    {'=', "0444 0646"},
    {'_', "0141"},
    {'/', "0248"},
    {'%', "0248 1717 3333"},
    {'^', "162836"},
    {'(', "38272332"},
    {')', "18272312"},
    {'[', "38282232"},
    {']', "18282212"},
    {'\'', "2826"},
    {'"', "1816 3836"},
    {'*', "2428 1537 1735"},
    {'<', "470543"},
    {'>', "074503"},
    {'!', "2824 2222"},
    {'~', "0516253445"},
    {'#', "1218 3238 0444 0646"},
    {'&',
     "4206173706031232"
     "44"},
    {';', "222311 2626"},
    {'|', "2028"},
    {'?',
     "0718384746242"
     "3 2222"},
    {'\x01', "0600 0312324346"},
    {'\x02',
     "171828271"
     "7"},
    {'\x03',
     "18384736154"
     "5"},
    {'\x04', "18384736264514"},
};
constexpr double kAdvance = 6;  // From a letter to the next, in grid units.
constexpr double kCapital = 6;  // The height of a capital letter.
constexpr double kBaseline = 2;

// Converts UTF-8 to one character per glyph; non-ASCII ones become numbers in the table.
std::string by_glyph(std::string_view utf8) {
  constexpr std::pair<std::string_view, char> kOthers[] = {{"\xc2\xb5", '\x01'},
                                                           {"\xce\xbc", '\x01'},
                                                           {"\xc2\xb0", '\x02'},
                                                           {"\xc2\xb2", '\x03'},
                                                           {"\xc2\xb3", '\x04'}};
  std::string glyphs;
  while (!utf8.empty()) {
    const auto other = std::find_if(std::begin(kOthers), std::end(kOthers),
                                    [&](const auto& one) { return utf8.starts_with(one.first); });
    if (other != std::end(kOthers)) {
      glyphs += other->second;
      utf8.remove_prefix(other->first.size());
      continue;
    }
    const unsigned char first = static_cast<unsigned char>(utf8.front());
    if (first < 0x80) glyphs += first < 0x20 ? '?' : utf8.front();
    if (first >= 0xc0) glyphs += '?';  // Continuation bytes have no glyph.
    utf8.remove_prefix(1);
  }
  return glyphs;
}

std::string_view lines_of(char character) {
  if (character == ' ') return {};
  const auto find = [](char wanted) {
    return std::find_if(std::begin(kGlyphs), std::end(kGlyphs),
                        [&](const Glyph& glyph) { return glyph.character == wanted; });
  };
  const auto found = find(character);
  return (found != std::end(kGlyphs) ? found : find('?'))->lines;
}

std::vector<Stroke> strokes_of(std::string_view utf8, double left, double baseline, double height) {
  const double unit = height / kCapital;
  std::vector<Stroke> strokes;
  double x = left;
  for (const char character : by_glyph(utf8)) {
    const std::string_view lines = lines_of(character);
    const auto place = [&](std::size_t i) {
      return std::array<double, 2>{x + unit * (lines[i] - '0'),
                                   baseline - unit * (lines[i + 1] - '0' - kBaseline)};
    };
    for (std::size_t i = 0; i + 3 < lines.size(); i += 2) {
      if (lines[i + 2] == ' ') {
        ++i;
        continue;
      }
      strokes.push_back({.from = place(i), .to = place(i + 2)});
    }
    x += kAdvance * unit;
  }
  return strokes;
}

double distance(double x, double y, const Stroke& stroke) {
  const double dx = stroke.to[0] - stroke.from[0];
  const double dy = stroke.to[1] - stroke.from[1];
  const double square = dx * dx + dy * dy;
  const double along = (x - stroke.from[0]) * dx + (y - stroke.from[1]) * dy;
  const double share = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
  return std::hypot(x - stroke.from[0] - share * dx, y - stroke.from[1] - share * dy);
}

void mix(Pixel& pixel, Rgb color, double share) {
  const double below = pixel[3] / 255.0 * (1 - share);
  const double opacity = share + below;
  for (std::size_t i = 0; i < 3; ++i) {
    pixel[i] =
        static_cast<std::uint8_t>(std::lround((share * color[i] + below * pixel[i]) / opacity));
  }
  pixel[3] = static_cast<std::uint8_t>(std::lround(255 * opacity));
}

}  // namespace

void draw_strokes(Picture& picture, std::span<const Stroke> strokes, double width, Rgb color) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double low[2] = {kFar, kFar};
  double high[2] = {-kFar, -kFar};
  for (const Stroke& stroke : strokes) {
    for (const auto& end : {stroke.from, stroke.to}) {
      for (const std::size_t axis : {0U, 1U}) {
        low[axis] = std::min(low[axis], end[axis] - width);
        high[axis] = std::max(high[axis], end[axis] + width);
      }
    }
  }
  const auto within = [](double value, int size) {
    return static_cast<int>(std::clamp<double>(value, 0, size));
  };
  for (int y = within(low[1], picture.height); y < within(high[1] + 1, picture.height); ++y) {
    for (int x = within(low[0], picture.width); x < within(high[0] + 1, picture.width); ++x) {
      double least = kFar;
      for (const Stroke& stroke : strokes)
        least = std::min(least, distance(x + 0.5, y + 0.5, stroke));
      const double share = std::clamp(0.5 * width + 0.5 - least, 0.0, 1.0);
      if (share > 0) {
        mix(picture.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                           static_cast<std::size_t>(x)],
            color, share);
      }
    }
  }
}

double text_width(std::string_view utf8, double height) {
  const std::size_t letters = by_glyph(utf8).size();
  return letters == 0 ? 0 : (kAdvance * static_cast<double>(letters) - 2) * height / kCapital;
}

void draw_text(Picture& picture, std::string_view utf8, double left, double baseline, double height,
               Rgb ink, Rgb rim) {
  const std::vector<Stroke> strokes = strokes_of(utf8, left, baseline, height);
  const double width = std::max(1.0, 0.15 * height);
  draw_strokes(picture, strokes, width + 0.3 * height, rim);
  draw_strokes(picture, strokes, width, ink);
}

}  // namespace multitetra

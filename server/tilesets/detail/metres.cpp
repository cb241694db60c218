#include "server/tilesets/detail/metres.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>

namespace multitetra {

std::optional<double> metres_of(std::string_view unit) {
  static constexpr std::array<std::pair<std::string_view, double>, 28> kUnits = {
      {{"m", 1},
       {"meter", 1},
       {"metre", 1},
       {"km", 1e3},
       {"kilometer", 1e3},
       {"kilometre", 1e3},
       {"cm", 1e-2},
       {"centimeter", 1e-2},
       {"centimetre", 1e-2},
       {"mm", 1e-3},
       {"millimeter", 1e-3},
       {"millimetre", 1e-3},
       {"um", 1e-6},
       {"\xC2\xB5m", 1e-6},  // Micro sign, then Greek mu.
       {"\xCE\xBCm", 1e-6},
       {"micron", 1e-6},
       {"micrometer", 1e-6},
       {"micrometre", 1e-6},
       {"nm", 1e-9},
       {"nanometer", 1e-9},
       {"nanometre", 1e-9},
       {"\xC3\x85", 1e-10},
       {"angstrom", 1e-10},
       {"pm", 1e-12},
       {"bohr", 5.29177210903e-11},
       {"in", 0.0254},
       {"inch", 0.0254},
       {"ft", 0.3048}}};
  std::string word(unit);
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) {
    return c < 0x80 ? static_cast<char>(std::tolower(c)) : static_cast<char>(c);
  });
  const auto length = [](std::string_view name) -> std::optional<double> {
    for (const auto& [known, metres] : kUnits) {
      if (known == name) return metres;
    }
    return std::nullopt;
  };
  if (const auto metres = length(word)) return metres;
  if (word.size() > 3 && word.back() == 's') return length(word.substr(0, word.size() - 1));
  return std::nullopt;
}

double metres_a_unit(const DatasetInfo& info) {
  return metres_of(info.meaning.length_unit).value_or(1);
}

}  // namespace multitetra

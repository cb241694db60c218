#include "common/dataset/length_units.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "common/dataset/physical_meaning.hpp"

namespace multitetra {
namespace {

struct LengthUnit {
  std::string_view symbol;
  double metres;
  std::array<std::string_view, 5> words;  // In lower case and singular.
};

constexpr std::array<LengthUnit, 13> kUnits = {
    {{"m", 1, {"m", "meter", "metre"}},
     {"km", 1e3, {"km", "kilometer", "kilometre"}},
     {"dm", 1e-1, {"dm", "decimeter", "decimetre"}},
     {"cm", 1e-2, {"cm", "centimeter", "centimetre"}},
     {"mm", 1e-3, {"mm", "millimeter", "millimetre"}},
     {"µm", 1e-6, {"um", "\xC2\xB5m", "\xCE\xBCm", "micrometer", "micrometre"}},  // Both mus.
     {"µm", 1e-6, {"micron"}},
     {"nm", 1e-9, {"nm", "nanometer", "nanometre"}},
     {"Å", 1e-10, {"\xC3\x85", "angstrom", "\xC3\xA5ngstr\xC3\xB6m"}},
     {"pm", 1e-12, {"pm", "picometer", "picometre"}},
     {"bohr", 5.29177210903e-11, {"bohr"}},
     {"in", 0.0254, {"in", "inch"}},
     {"ft", 0.3048, {"ft", "foot", "feet"}}}};

const LengthUnit* length_unit(std::string_view word) {
  for (const LengthUnit& unit : kUnits) {
    if (!word.empty() && std::find(unit.words.begin(), unit.words.end(), word) != unit.words.end())
      return &unit;
  }
  return nullptr;
}

const LengthUnit* length_unit_of(std::string_view text) {
  if (const LengthUnit* const unit = length_unit(text)) return unit;
  if (text.size() < 4) return nullptr;  // Symbols depend on case: "Mm" is no millimetre.
  std::string word(text);
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) {
    return c < 0x80 ? static_cast<char>(std::tolower(c)) : static_cast<char>(c);
  });
  if (const LengthUnit* const unit = length_unit(word)) return unit;
  if (word.size() <= 3 || word.back() != 's') return nullptr;
  word.pop_back();
  return length_unit(word);
}

}  // namespace

std::optional<double> metres_of(std::string_view unit) {
  const LengthUnit* const known = length_unit_of(unit);
  return known ? std::optional(known->metres) : std::nullopt;
}

std::optional<double> length_factor(std::string_view unit, std::string_view other) {
  const std::optional<double> from = metres_of(unit);
  const std::optional<double> to = metres_of(other);
  if (!from || !to) return std::nullopt;
  const double ratio = std::max(*from, *to) / std::min(*from, *to);
  const double whole = std::round(ratio);
  const double exact = std::abs(ratio - whole) < 1e-9 * ratio ? whole : ratio;
  return *from >= *to ? exact : 1 / exact;
}

std::string unit_from(std::string_view text) {
  // Words only: "M" or "MM" may be other units.
  const bool is_word = text.size() > 2 || text == "um";
  if (const LengthUnit* const known = is_word ? length_unit_of(text) : nullptr) {
    return std::string(known->symbol);
  }
  if (text == "pixel" || text == "pixels") return {};
  return is_unit_text(text) ? std::string(text) : std::string();
}

}  // namespace multitetra

#include "common/dataset/physical_meaning.hpp"

#include "common/base/enum_names.hpp"
#include "common/base/utf8.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<WorldSpace, 3> kSpaces = {{"", "LPS", "RAS"}};
constexpr EnumNames<GeometryBasis, 4> kBases = {{"", "stated", "partly", "assumed"}};

}  // namespace

std::string_view name(WorldSpace space) { return kSpaces.of(space); }

std::optional<WorldSpace> world_space_from(std::string_view name) { return kSpaces.find(name); }

std::string_view name(GeometryBasis basis) { return kBases.of(basis); }

std::optional<GeometryBasis> geometry_basis_from(std::string_view name) {
  return kBases.find(name);
}

std::string geometry_text(const PhysicalMeaning& meaning) {
  std::string text(name(meaning.geometry));
  if (meaning.assumed.empty() || text.empty()) return text;
  const bool is_several = meaning.assumed.find(", ") != std::string::npos;
  return text + " (" + meaning.assumed + (is_several ? " are assumed)" : " is assumed)");
}

std::string rounding_text(const std::string& source, const PhysicalMeaning& meaning) {
  if (meaning.rounding.empty()) return {};
  return "The samples of \"" + source + "\" were rounded to 32-bit floats (" + meaning.rounding +
         "); surfaces are those of the rounded samples.";
}

bool is_unit_text(std::string_view text) {
  return text.size() <= kMaxUnitBytes && is_plain_text(text);
}

}  // namespace multitetra

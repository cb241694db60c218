#include "common/request/physical_meaning.hpp"

#include <algorithm>
#include <array>

#include "common/base/utf8.hpp"

namespace multitetra {
namespace {

constexpr std::array<std::string_view, 3> kSpaceNames = {"", "LPS", "RAS"};

}  // namespace

std::string_view name(WorldSpace space) { return kSpaceNames[static_cast<std::size_t>(space)]; }

std::optional<WorldSpace> world_space_from(std::string_view name) {
  const auto found = std::find(kSpaceNames.begin(), kSpaceNames.end(), name);
  if (found == kSpaceNames.end()) return std::nullopt;
  return static_cast<WorldSpace>(found - kSpaceNames.begin());
}

bool is_unit_text(std::string_view text) {
  return text.size() <= kMaxUnitBytes && is_plain_text(text);
}

}  // namespace multitetra

#include "common/dataset/physical_meaning.hpp"

#include "common/base/enum_names.hpp"
#include "common/base/utf8.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<WorldSpace, 3> kSpaces = {{"", "LPS", "RAS"}};

}  // namespace

std::string_view name(WorldSpace space) { return kSpaces.of(space); }

std::optional<WorldSpace> world_space_from(std::string_view name) { return kSpaces.find(name); }

bool is_unit_text(std::string_view text) {
  return text.size() <= kMaxUnitBytes && is_plain_text(text);
}

}  // namespace multitetra

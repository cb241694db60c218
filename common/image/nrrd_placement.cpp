#include "common/image/nrrd_placement.hpp"

#include <algorithm>
#include <string_view>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

std::string unquoted(std::string text) {
  std::erase(text, '"');
  return text;
}

// Returns 1 or -1 for x, y and z along or against LPS; nullopt inside for spaces without a patient.
Result<std::optional<Vec3>> patient_signs(std::string_view written) {
  std::string space = lower_case(written);
  if (space.ends_with("-time")) space.erase(space.size() - 5);
  if (space.empty() || space == "scanner-xyz" || space == "3d-right-handed" ||
      space == "3d-left-handed") {
    return std::nullopt;
  }
  if (space.find('-') == std::string::npos && space.size() == 4 && space.back() == 't') {
    space.pop_back();
  }
  std::string letters;  // "lps" for "left-posterior-superior"
  for (std::size_t at = 0; at < space.size(); ++at) {
    if (space.size() == 3 || at == 0 || space[at - 1] == '-') letters += space[at];
  }
  constexpr std::string_view kSame = "lps";
  constexpr std::string_view kOpposite = "rai";
  Vec3 signs;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_opposite = letters.size() == 3 && letters[axis] == kOpposite[axis];
    if (letters.size() != 3 || (letters[axis] != kSame[axis] && !is_opposite)) {
      return fail(ErrorCode::kInvalidArgument,
                  "its space '" + std::string(written.substr(0, 60)) + "' is unknown");
    }
    signs[axis] = is_opposite ? -1 : 1;
  }
  return signs;
}

std::optional<Vec3> vector_from(const std::string& text) {
  std::vector<double> numbers = finite_numbers(text);
  if (numbers.size() < 2) return std::nullopt;
  numbers.resize(3);
  return Vec3{numbers[0], numbers[1], numbers[2]};
}

// An axis without a direction in space: its spacing, or else its ends, say where samples are.
struct Axis {
  double step = 0;                             // 0 if it is not stated.
  std::optional<double> first = std::nullopt;  // The center of the first sample.
};

Axis axis_of(const NrrdHeader& header, const std::vector<std::int64_t>& sizes, std::size_t axis) {
  const auto word = [&](std::string_view field) {
    const std::vector<std::string> words = header.axis_words(field, sizes.size());
    return words.empty() ? std::string() : words[axis];
  };
  const std::optional<double> min = finite_number(word("axis mins"));
  const std::optional<double> max = finite_number(word("axis maxs"));
  const bool is_node = lower_case(word("centers")) == "node";
  Axis result{.step = finite_number(word("spacings")).value_or(0)};
  if (result.step == 0 && min && max && sizes[axis] > 1) {
    result.step = (*max - *min) / static_cast<double>(is_node ? sizes[axis] - 1 : sizes[axis]);
  }
  if (min && result.step != 0) result.first = is_node ? *min : *min + result.step / 2;
  return result;
}

}  // namespace

Result<NrrdPlacement> nrrd_placement(const NrrdHeader& header,
                                     const std::vector<std::int64_t>& sizes,
                                     const std::vector<std::size_t>& axes) {
  const auto words = [&](std::string_view field) { return header.axis_words(field, sizes.size()); };
  const std::vector<std::string> directions = words("space directions");
  const auto signs = patient_signs(header.field("space"));
  if (!signs) return tl::unexpected(signs.error());
  const auto turned = [&](const Vec3& vector) {
    const Vec3 by = signs->value_or(Vec3{1, 1, 1});
    return Vec3{vector[0] * by[0], vector[1] * by[1], vector[2] * by[2]};
  };
  NrrdPlacement placement;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!directions.empty()) {
      const std::optional<Vec3> direction = vector_from(directions[axes[i]]);
      if (direction) placement.steps[i] = turned(*direction);
    } else {
      const Axis own = axis_of(header, sizes, axes[i]);
      placement.steps[i][i] = own.step;
      placement.first[i] = own.first;
    }
  }
  const bool is_in_space = !directions.empty() || words("spacings").empty();
  if (is_in_space) {
    placement.signs = *signs;
    if (const std::optional<Vec3> origin = vector_from(header.field("space origin"))) {
      const Vec3 first = turned(*origin);
      placement.first = {first[0], first[1], first[2]};
    }
    // All axes of space have the unit of the first.
    const std::string units = header.field("space units");
    placement.unit = unquoted(units.substr(0, units.find('"', 1)));
  }
  const std::vector<std::string> own_units = words("units");
  for (std::size_t i = 0; i < axes.size() && directions.empty() && !own_units.empty(); ++i) {
    placement.units_of_axes[i] = unquoted(own_units[axes[i]]);
  }
  return placement;
}

}  // namespace multitetra

#include "server/volume/formats/detail/nrrd_axes.hpp"

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string unquoted(std::string text) {
  std::erase(text, '"');
  return text;
}

bool is_of_space(const std::string& kind) {
  return kind == "domain" || kind == "space" || kind == "time" || kind == "none" || kind == "???";
}

// Returns which of four axes contains times.
std::optional<std::size_t> time_axis(const NrrdHeader& header, bool has_components) {
  std::vector<std::size_t> others;
  const std::vector<std::string> kinds = header.axis_words("kinds", 4);
  for (std::size_t axis = 0; axis < kinds.size(); ++axis) {
    const std::string kind = lower_case(kinds[axis]);
    if (kind == "domain" || kind == "space") continue;
    const bool may_be_time = kind == "list" || is_of_space(kind);
    if (!may_be_time || (has_components && kind != "time")) return std::nullopt;
    others.push_back(axis);
  }
  for (const auto& [field, word] :
       {std::pair{"space directions", "none"}, std::pair{"spacings", "nan"}}) {
    if (!others.empty()) break;
    const std::vector<std::string> words = header.axis_words(field, 4);
    for (std::size_t axis = 0; axis < words.size(); ++axis) {
      if (lower_case(words[axis]) == word) others.push_back(axis);
    }
  }
  if (others.empty()) others.push_back(3);
  const bool is_outermost = others.front() == 0 || others.front() == 3;
  return others.size() == 1 && is_outermost ? std::optional(others.front()) : std::nullopt;
}

// Returns 1 or -1 for x, y and z along or against LPS; nullopt for spaces without a patient.
std::optional<Vec3> patient_signs(const fs::path& file, std::string_view written) {
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
  const auto sign = [&](std::size_t axis, char same, char opposite) {
    if (letters.size() == 3 && letters[axis] == same) return 1.0;
    if (letters.size() == 3 && letters[axis] == opposite) return -1.0;
    fail_reading(file, "its space '" + std::string(written.substr(0, 60)) + "' is unknown",
                 "Use left-posterior-superior, right-anterior-superior or left-anterior-superior");
  };
  return Vec3{sign(0, 'l', 'r'), sign(1, 'p', 'a'), sign(2, 's', 'i')};
}

std::optional<Vec3> vector_from(const std::string& text) {
  std::vector<double> numbers = finite_numbers(text);
  if (numbers.size() < 2) return std::nullopt;
  numbers.resize(3);
  return Vec3{numbers[0], numbers[1], numbers[2]};
}

Vec3 turned(const Vec3& vector, const std::optional<Vec3>& signs) {
  if (!signs) return vector;
  return {vector[0] * (*signs)[0], vector[1] * (*signs)[1], vector[2] * (*signs)[2]};
}

// An axis without a direction in space: its spacing, or else its ends, say where samples are.
struct NrrdAxis {
  double step = 0;                             // 0 if it is not stated.
  std::optional<double> first = std::nullopt;  // The center of the first sample.
};

NrrdAxis axis_of(const NrrdHeader& header, const std::vector<std::int64_t>& sizes,
                 std::size_t axis) {
  const auto word = [&](std::string_view field) {
    const std::vector<std::string> words = header.axis_words(field, sizes.size());
    return words.empty() ? std::string() : words[axis];
  };
  const std::optional<double> min = finite_number(word("axis mins"));
  const std::optional<double> max = finite_number(word("axis maxs"));
  const bool is_node = lower_case(word("centers")) == "node";
  NrrdAxis result{.step = finite_number(word("spacings")).value_or(0)};
  if (result.step == 0 && min && max && sizes[axis] > 1) {
    result.step = (*max - *min) / static_cast<double>(is_node ? sizes[axis] - 1 : sizes[axis]);
  }
  if (min && result.step != 0) result.first = is_node ? *min : *min + result.step / 2;
  return result;
}

}  // namespace

NrrdAxes nrrd_axes(const fs::path& file, const NrrdHeader& header,
                   const std::vector<std::int64_t>& sizes, bool has_components) {
  NrrdAxes axes;
  if (sizes.size() == 4) axes.time = time_axis(header, has_components);
  const std::vector<std::string> kinds = header.axis_words("kinds", sizes.size());
  for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
    if (axis == axes.time) continue;
    if (kinds.empty() || is_of_space(lower_case(kinds[axis]))) {
      if (axes.space.size() < 3) {
        axes.space.push_back(axis);
      } else if (sizes[axis] != 1) {
        fail_reading(file,
                     "it has " + std::to_string(sizes.size()) + " dimensions, with " +
                         std::to_string(sizes[axis]) + " volumes along dimension " +
                         std::to_string(axis + 1),
                     "Give a single volume of three dimensions, for example one time step");
      }
    } else if (axes.component || (axis != 0 && axis + 1 != sizes.size())) {
      fail_reading(file,
                   "its axis " + std::to_string(axis + 1) + " of kind " + kinds[axis] +
                       " is neither the first nor the last axis",
                   "Permute its axes, so that the components of a sample come first");
    } else {
      axes.component = axis;
    }
  }
  if (axes.space.size() < 2)
    fail_reading(file, "it has one dimension", "Give an image or a volume");
  return axes;
}

SourceTimes nrrd_times(const NrrdHeader& header, std::size_t axis, std::int64_t count) {
  const std::string prefix = "axis " + std::to_string(axis) + " index ";
  for (const auto& [values, unit] :
       {std::pair{prefix + "values", prefix + "unit"},
        {"MultiVolume.FrameLabels", "MultiVolume.FrameIdentifyingUnits"}}) {
    SourceTimes times{.count = count, .at = finite_numbers(header.key(values))};
    if (count > 1 && times.at.size() == static_cast<std::size_t>(count)) {
      times.unit = time_unit_from(header.key(unit));
      return times;
    }
  }
  const auto word = [&](std::string_view field) {
    const std::vector<std::string> words = header.axis_words(field, 4);
    return words.empty() ? std::string() : words[axis];
  };
  return even_times(count, finite_number(word("axis mins")).value_or(0),
                    finite_number(word("spacings")).value_or(0), unquoted(word("units")));
}

void place_nrrd(const fs::path& file, const NrrdHeader& header, const NrrdAxes& axes,
                const std::vector<std::int64_t>& sizes, ImageHeader& image) {
  const auto words = [&](std::string_view field) { return header.axis_words(field, sizes.size()); };
  const std::vector<std::string> directions = words("space directions");
  const std::optional<Vec3> signs = patient_signs(file, header.field("space"));
  const bool only_spacings = directions.empty() && !words("spacings").empty();
  std::array<Vec3, 3> steps{};
  StatedNumbers first = kNotStated;
  for (std::size_t i = 0; i < axes.space.size(); ++i) {
    const std::size_t axis = axes.space[i];
    if (!directions.empty()) {
      const std::optional<Vec3> direction = vector_from(directions[axis]);
      if (direction) steps[i] = turned(*direction, signs);
    } else {
      const NrrdAxis own = axis_of(header, sizes, axis);
      steps[i][i] = own.step;
      first[i] = own.first;
    }
  }
  const std::optional<Vec3> origin = vector_from(header.field("space origin"));
  if (origin && !only_spacings) {
    set_axes(image, steps, stated(turned(*origin, signs)));
  } else {
    set_axes(image, steps, first);
  }
  if (signs && !only_spacings) {
    image.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = {}};
  }
  const std::string units = only_spacings ? std::string() : header.field("space units");
  if (const std::string unit = unit_from(unquoted(units.substr(0, units.find('"', 1))));
      !unit.empty()) {
    image.meaning.length_unit = unit;  // All axes of space have that of the first.
    return;
  }
  const std::vector<std::string> own_units = words("units");
  std::array<std::string, 3> of_axes{};
  for (std::size_t i = 0; i < axes.space.size() && directions.empty() && !own_units.empty(); ++i) {
    of_axes[i] = unit_from(unquoted(own_units[axes.space[i]]));
  }
  set_units_of_axes(image, of_axes);
}

}  // namespace multitetra

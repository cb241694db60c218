#include "server/volume/formats/detail/nrrd_axes.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/text.hpp"
#include "common/image/nrrd_placement.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

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
  std::string unit = word("units");
  std::erase(unit, '"');
  return even_times(count, finite_number(word("axis mins")).value_or(0),
                    finite_number(word("spacings")).value_or(0), unit);
}

void place_nrrd(const fs::path& file, const NrrdHeader& header, const NrrdAxes& axes,
                const std::vector<std::int64_t>& sizes, ImageHeader& image) {
  const auto placement = nrrd_placement(header, sizes, axes.space);
  if (!placement) {
    fail_reading(file, placement.error().text,
                 "Use left-posterior-superior, right-anterior-superior or left-anterior-superior");
  }
  set_axes(image, placement->steps, placement->first);
  if (placement->signs) {
    image.turned_by = *placement->signs;
    image.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = {}};
  }
  if (std::string unit = unit_from(placement->unit); !unit.empty()) {
    image.meaning.length_unit = std::move(unit);
    return;
  }
  std::array<std::string, 3> units;
  std::ranges::transform(placement->units_of_axes, units.begin(), unit_from);
  set_units_of_axes(image, units);
}

}  // namespace multitetra

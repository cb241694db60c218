#include "server/volume/formats/stored_volume.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/address_text.hpp"
#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/base/utf8.hpp"
#include "common/base/vec3.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

}  // namespace

void fail_reading(const fs::path& file, const std::string& problem, const std::string& remedy) {
  constexpr std::size_t kMaxBytes = 4000;
  std::string text = printable(
      "Cannot read '" + without_password(file.string()) + "': " + problem + ". " + remedy + ".",
      /*keeps_lines=*/false);
  if (text.size() > kMaxBytes) text = text.substr(0, kMaxBytes) + "...";
  throw VolumeFileError(text);
}

void fail_damaged(const fs::path& file, const std::string& problem) {
  fail_reading(file, problem, "Get a complete copy of the file");
}

std::optional<ComponentChoice> ComponentChoice::from(std::string_view text) {
  if (text == "magnitude") return ComponentChoice{.kind = Kind::kMagnitude};
  if (text == "luminance") return ComponentChoice{.kind = Kind::kLuminance};
  const auto index = parse_number<int>(text);
  if (!index || *index < 0) return std::nullopt;
  return ComponentChoice{.kind = Kind::kIndex, .index = *index};
}

std::int64_t chosen_entry(const fs::path& file, const FileEntries& entries,
                          std::optional<std::int64_t> wanted, bool takes_first) {
  if (entries.count < 1) fail_damaged(file, entries.several);
  if (entries.count != 1 && !wanted && !takes_first) {
    fail_reading(file, entries.several, entries.remedy);
  }
  const std::int64_t entry = wanted.value_or(0);
  if (entry >= 0 && entry < entries.count) return entry;
  fail_reading(file, entries.missing + " " + std::to_string(entry),
               "Choose 0 to " + std::to_string(entries.count - 1));
}

std::int64_t chosen_time(const fs::path& file, std::int64_t count, const VolumeChoice& choice) {
  return chosen_entry(file,
                      {.count = count,
                       .several = "it has " + std::to_string(count) + " volumes, one for each time",
                       .remedy = kChooseTime},
                      choice.time, choice.first);
}

void check_header(const fs::path& file, const ImageHeader& header) {
  for (const std::int64_t side : header.dims) {
    if (side >= 1 && side <= kMaxSide) continue;
    fail_reading(file, "it has " + sides_text(header.dims) + " samples",
                 "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
  }
  if (header.components < 1 || header.components > kMaxComponents) {
    fail_reading(file, "each sample has " + std::to_string(header.components) + " components",
                 "It must have 1 to " + std::to_string(kMaxComponents));
  }
  if (!std::isfinite(header.slope) || header.slope == 0 || !std::isfinite(header.intercept)) {
    fail_reading(file,
                 "its slope " + rounded_text(header.slope) + " and intercept " +
                     rounded_text(header.intercept) + " are invalid",
                 "Correct the header: the slope must not be 0, and both must be finite");
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::isfinite(header.spacing[axis]) && header.spacing[axis] > 0) continue;
    fail_reading(file,
                 "its spacing along axis " + std::to_string(axis + 1) + " is " +
                     rounded_text(header.spacing[axis]),
                 "Correct the header: spacings must be positive numbers");
  }
  const double volume = header.index_to_world.determinant();
  const Vec3& origin = header.index_to_world.translation;
  if (!std::isfinite(volume) || volume == 0 || !std::isfinite(origin[0] + origin[1] + origin[2])) {
    fail_reading(file, "its axis directions are linearly dependent",
                 "Correct the header: the three directions must be independent");
  }
}

void set_box_axes(ImageHeader& header, const Vec3& origin, const Vec3& spacing) {
  header.index_to_world = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.spacing[axis] = std::abs(spacing[axis]);
    header.index_to_world.columns[axis] = {0, 0, 0};
    header.index_to_world.columns[axis][axis] = spacing[axis];
  }
  header.index_to_world.translation = origin;
}

void set_axes(ImageHeader& header, const std::array<Vec3, 3>& steps, const Vec3& origin) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.spacing[axis] = length(steps[axis]);
    for (std::size_t row = 0; row < 3; ++row) {
      header.index_to_world.columns[axis][row] = steps[axis][row] + 0.0;  // Turns -0 into 0.
    }
  }
  header.index_to_world.translation = origin;
}

void ras_to_lps(std::array<Vec3, 3>& steps, Vec3& origin) {
  for (Vec3* vector : {&steps[0], &steps[1], &steps[2], &origin}) {
    (*vector)[0] = 0 - (*vector)[0];
    (*vector)[1] = 0 - (*vector)[1];
  }
}

std::string unit_from(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 18> kSymbols = {
      {{"millimeter", "mm"},
       {"millimetre", "mm"},
       {"micrometer", "µm"},
       {"micrometre", "µm"},
       {"micron", "µm"},
       {"um", "µm"},
       {"\xce\xbcm", "µm"},  // With a Greek mu instead of the micro sign.
       {"nanometer", "nm"},
       {"nanometre", "nm"},
       {"meter", "m"},
       {"metre", "m"},
       {"centimeter", "cm"},
       {"centimetre", "cm"},
       {"angstrom", "Å"},
       {"kilometer", "km"},
       {"kilometre", "km"},
       {"ångström", "Å"},
       {"pixel", ""}}};
  std::string_view one = text;
  if (one.size() > 2 && one.ends_with('s')) one.remove_suffix(1);
  for (const auto& [word, symbol] : kSymbols) {
    if (text == word || one == word) return std::string(symbol);
  }
  return is_unit_text(text) ? std::string(text) : std::string();
}

fs::path named_data_file(const fs::path& header, const std::string& name,
                         bool allow_external_files) {
  const fs::path folder = header.has_parent_path() ? header.parent_path() : fs::path(".");
  const fs::path file = folder / name;
  std::error_code error;
  const fs::path inside =
      fs::weakly_canonical(file, error).lexically_relative(fs::weakly_canonical(folder, error));
  if (!allow_external_files && (error || inside.empty() || *inside.begin() == "..")) {
    fail_reading(
        header, "it refers to the data file '" + name + "', which is outside the header's folder",
        "Put the data beside the header, or allow it with --follow if you trust the header");
  }
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) {
    fail_reading(header, "its data file '" + name + "' is missing",
                 "Put the data file beside the header");
  }
  if (!fs::is_regular_file(status)) {
    fail_reading(header, "its data file '" + name + "' is not a regular file",
                 "Give a header whose samples are in a file");
  }
  return file;
}

}  // namespace multitetra

#include <algorithm>
#include <optional>
#include <set>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/arrays/bdv_description.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

// "/t00000/s00/0/cells" in HDF5, "setup0/timepoint0/s0" in N5.
struct ViewPath {
  std::int64_t time = 0;
  std::int64_t setup = 0;
  std::int64_t level = 0;
  std::string setup_group;  // "s00" or "setup0"
  bool is_hdf5 = true;
};

std::optional<std::int64_t> number_after(std::string_view part, std::string_view prefix) {
  if (!part.starts_with(prefix)) return std::nullopt;
  return parse_number<std::int64_t>(part.substr(prefix.size()));
}

std::optional<ViewPath> view_path(std::string_view array) {
  if (array.starts_with('/')) array.remove_prefix(1);
  const std::vector<std::string_view> parts = split(array, '/');
  const bool is_hdf5 = parts.size() == 4 && parts[3] == "cells";
  if (!is_hdf5 && parts.size() != 3) return std::nullopt;
  const std::size_t of_setup = is_hdf5 ? 1 : 0;
  const auto time = number_after(parts[1 - of_setup], is_hdf5 ? "t" : "timepoint");
  const auto setup = number_after(parts[of_setup], is_hdf5 ? "s" : "setup");
  const auto level = number_after(parts[2], is_hdf5 ? "" : "s");
  if (!time || !setup || !level) return std::nullopt;
  return ViewPath{.time = *time,
                  .setup = *setup,
                  .level = *level,
                  .setup_group = std::string(parts[of_setup]),
                  .is_hdf5 = is_hdf5};
}

// How many finest samples a sample of the level stands for, along x, y, z; nothing if unknown.
std::optional<std::array<double, 3>> factors_of(const ArrayContainer& file,
                                                const std::string& array, const ViewPath& path) {
  const std::vector<double> all = path.is_hdf5
                                      ? file.values("/" + path.setup_group + "/resolutions")
                                      : file.numbers(array, "downsamplingFactors");
  const std::size_t at = path.is_hdf5 ? 3 * static_cast<std::size_t>(path.level) : 0;
  if (all.empty() && path.level == 0) return std::array<double, 3>{1, 1, 1};
  if (all.size() < at + 3) return std::nullopt;
  const std::array<double, 3> factors = {all[at], all[at + 1], all[at + 2]};
  const bool are_valid = std::all_of(factors.begin(), factors.end(), stated_spacing);
  return are_valid ? std::optional(factors) : std::nullopt;
}

// Returns the timepoints that the file has of a setup, in order.
std::set<std::int64_t> times_of(const ArrayContainer& file, std::int64_t setup) {
  std::set<std::int64_t> times;
  for (const std::string& array : file.arrays()) {
    const auto path = view_path(array);
    if (path && path->setup == setup) times.insert(path->time);
  }
  return times;
}

}  // namespace

// Level and time choose; of several setups, each is offered.
std::vector<std::string> big_data_viewer_arrays(const ArrayContainer& file,
                                                const VolumeChoice& choice) {
  std::vector<std::string> found;
  for (const std::string& array : file.arrays()) {
    const auto path = view_path(array);
    if (!path || path->level != choice.level.value_or(0)) continue;
    if (path->is_hdf5 && file.shape("/" + path->setup_group + "/resolutions").empty()) continue;
    const std::set<std::int64_t> times = times_of(file, path->setup);
    const std::int64_t time = chosen_time(file.file(), std::ssize(times), choice);
    if (path->time == *std::next(times.begin(), time)) found.push_back(array);
  }
  return found;
}

bool describe_big_data_viewer(const ArrayContainer& file, const std::string& array,
                              ArrayMeaning& meaning) {
  const std::optional<ViewPath> path = view_path(array);
  if (!path) return false;
  if (path->is_hdf5 && file.shape("/" + path->setup_group + "/resolutions").empty()) return false;
  meaning.has_levels = true;
  meaning.roles = {DimensionRole::kZ, DimensionRole::kY, DimensionRole::kX};
  meaning.times.count = std::ssize(times_of(file, path->setup));
  // HDF5 files have 16 bits, of type int16 for programs in Java, and are unsigned unless they say
  // otherwise.
  const std::string type =
      file.text(array, "dataType") + file.text("/" + path->setup_group, "dataType");
  meaning.is_unsigned = path->is_hdf5 && !type.starts_with("int");
  if (path->is_hdf5 && type.empty()) meaning.header.values.sign = Basis::kAssumed;
  const auto factors = factors_of(file, array, *path);
  const std::filesystem::path& xml = file.described_by;
  const auto description =
      xml.empty() ? bdv_description_beside(file.file()) : std::optional(bdv_description(xml));
  meaning.is_geometry_unread =
      !factors || !description ||
      !place_bdv_view(*description, path->time, path->setup, *factors, meaning.header);
  return true;
}

}  // namespace multitetra

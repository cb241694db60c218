#include "server/volume/formats/zarr/detail/ome_image.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMaxAxes = 8;

Json member_of(const Json& object, const char* key) {
  return object.is_object() ? object.value(key, Json()) : Json();
}

std::string text_in(const Json& object, const char* key) {
  const Json value = member_of(object, key);
  return value.is_string() ? value.get<std::string>() : std::string();
}

// Returns the attributes of OME-Zarr, which its later versions nest.
const Json& ome_of(const Json& attributes) {
  return attributes.is_object() && attributes.contains("ome") ? attributes.at("ome") : attributes;
}

// The map from an array's indices to coordinates, dimension by dimension: a row has the factors of
// each index and a constant.
class Transform {
 public:
  explicit Transform(std::size_t dimensions)
      : rows_(dimensions, std::vector<double>(dimensions + 1, 0)) {
    for (std::size_t d = 0; d < dimensions; ++d) rows_[d][d] = 1;
  }

  // Applies a list of transformations. Returns the type of the first one that is not read.
  [[nodiscard]] std::optional<std::string> apply(const Json& transformations, int depth = 0) {
    if (!transformations.is_array() || depth > 4) return std::nullopt;
    for (const Json& one : transformations) {
      const std::string type = text_in(one, "type");
      if (type == "sequence") {
        if (auto unread = apply(member_of(one, "transformations"), depth + 1)) return unread;
      } else if (type != "identity" && !apply_one(type, one)) {
        return type.empty() ? "unnamed" : type;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] bool has_scale() const { return has_scale_; }
  [[nodiscard]] bool has_origin() const { return has_origin_; }
  [[nodiscard]] double factor(std::size_t to, std::size_t from) const { return rows_[to][from]; }
  [[nodiscard]] double constant(std::size_t to) const { return rows_[to].back(); }

 private:
  bool apply_one(const std::string& type, const Json& one) {
    const std::size_t n = rows_.size();
    std::vector<std::vector<double>> map(n, std::vector<double>(n + 1, 0));
    const Json numbers = member_of(one, type.c_str());
    if (!numbers.is_array() || numbers.size() != n) return false;
    for (std::size_t d = 0; d < n; ++d) {
      const Json& entry = numbers[d];
      if (type == "affine") {
        if (!entry.is_array() || entry.size() != n + 1) return false;
        for (std::size_t from = 0; from <= n; ++from) {
          if (!entry[from].is_number()) return false;
          map[d][from] = entry[from].get<double>();
        }
        continue;
      }
      if (!entry.is_number() || (type != "scale" && type != "translation")) return false;
      map[d][d] = type == "scale" ? entry.get<double>() : 1;
      map[d][n] = type == "translation" ? entry.get<double>() : 0;
    }
    has_scale_ |= type != "translation";
    has_origin_ |= type != "scale";
    compose(map);
    return true;
  }

  void compose(const std::vector<std::vector<double>>& map) {
    const std::size_t n = rows_.size();
    std::vector<std::vector<double>> rows(n, std::vector<double>(n + 1, 0));
    for (std::size_t to = 0; to < n; ++to) {
      rows[to][n] = map[to][n];
      for (std::size_t between = 0; between < n; ++between) {
        for (std::size_t from = 0; from <= n; ++from) {
          rows[to][from] += map[to][between] * rows_[between][from];
        }
      }
    }
    rows_ = std::move(rows);
  }

  std::vector<std::vector<double>> rows_;
  bool has_scale_ = false;
  bool has_origin_ = false;
};

// Returns the axes of a level: those of the image, or since 0.6 of the coordinate system to which
// the level's transformation leads.
Json axes_of_level(const Json& image, const Json& level, const VolumeChoice& choice,
                   const fs::path& place) {
  const Json systems = member_of(image, "coordinateSystems");
  if (!systems.is_array() || systems.empty()) return member_of(image, "axes");
  const Json transformations = member_of(level, "coordinateTransformations");
  const bool has_any = transformations.is_array() && !transformations.empty();
  const Json output = has_any ? member_of(transformations.back(), "output") : Json();
  const Json name = output.is_object() ? member_of(output, "name") : output;
  for (const Json& system : systems) {
    if (member_of(system, "name") == name) return member_of(system, "axes");
  }
  const bool is_only_one = name.is_null() && systems.size() == 1;
  if (!is_only_one && !(choice.given.spacing && choice.given.origin)) {
    fail_reading(place,
                 name.is_string()
                     ? "its transformation leads to the coordinate system '" +
                           name.get<std::string>() + "', which it does not describe"
                     : "it does not say to which of its coordinate systems a level leads",
                 "Correct its metadata, or give --spacing and --origin");
  }
  return member_of(systems[0], "axes");
}

// The size of a voxel, by which levels are sorted.
double voxel_of(const Json& level) {
  const Json transformations = member_of(level, "coordinateTransformations");
  if (!transformations.is_array()) return 1;
  double voxel = 1;
  for (const Json& one : transformations) {
    const Json inner =
        text_in(one, "type") == "sequence" ? member_of(one, "transformations") : Json::array({one});
    for (const Json& step : inner) {
      if (text_in(step, "type") != "scale" || !member_of(step, "scale").is_array()) continue;
      for (const Json& number : step.at("scale")) {
        if (number.is_number()) voxel *= number.get<double>();
      }
    }
  }
  return voxel;
}

void set_place(const Transform& transform, const std::vector<std::string>& units,
               ArrayMeaning& meaning) {
  std::array<std::optional<std::size_t>, 3> axes;
  std::optional<std::size_t> time;
  for (std::size_t d = 0; d < meaning.roles.size(); ++d) {
    if (meaning.roles[d] <= DimensionRole::kZ) axes[static_cast<std::size_t>(meaning.roles[d])] = d;
    if (meaning.roles[d] == DimensionRole::kTime) time = d;
  }
  std::array<Vec3, 3> steps{};
  StatedNumbers origin = kNotStated;
  std::array<std::string, 3> unit_of_axis;
  for (std::size_t to = 0; to < 3; ++to) {
    if (!axes[to]) continue;
    unit_of_axis[to] = units[*axes[to]];
    if (transform.has_origin()) origin[to] = transform.constant(*axes[to]);
    for (std::size_t from = 0; from < 3 && transform.has_scale(); ++from) {
      if (axes[from]) steps[from][to] = transform.factor(*axes[to], *axes[from]);
    }
  }
  set_axes(meaning.header, steps, origin);
  set_units_of_axes(meaning.header, unit_of_axis);
  // A scale without a unit is no time; the count is that of the array.
  if (!time || units[*time].empty() || !transform.has_scale()) return;
  meaning.times = {.at = {transform.constant(*time), transform.factor(*time, *time)},
                   .unit = units[*time]};
}

OmeLevel described(const Json& image, const Json& level, const VolumeChoice& choice,
                   const fs::path& place) {
  OmeLevel result{
      .path = text_in(level, "path"),
      .meaning = {.name = "OME-Zarr", .header = {.values = kNumbersAsStored}, .has_levels = true}};
  std::vector<std::string> names;
  std::vector<std::string> units;
  const Json axes = axes_of_level(image, level, choice, place);
  for (const Json& axis : axes.is_array() ? axes : Json::array()) {
    names.push_back(axis.is_string() ? axis.get<std::string>() : text_in(axis, "name"));
    units.push_back(text_in(axis, "unit"));
  }
  if (names.empty()) {  // From before axes had names: always t, c, z, y, x.
    names = {"t", "c", "z", "y", "x"};
    units.resize(5);
  }
  if (names.size() > kMaxAxes) fail_reading(place, "it has too many axes", "Correct its metadata");
  result.meaning.roles = roles_from(names);
  if (result.meaning.roles.empty()) {
    result.meaning.roles = roles_by_place(std::vector<std::int64_t>(names.size(), 2));
  }
  Transform transform(names.size());
  std::optional<std::string> unread =
      transform.apply(member_of(level, "coordinateTransformations"));
  if (!unread) unread = transform.apply(member_of(image, "coordinateTransformations"));
  if (unread && !(choice.given.spacing && choice.given.origin)) {
    fail_reading(place,
                 "its coordinateTransformations have one of type '" + *unread +
                     "' that is not a scale, translation or affine map of " +
                     std::to_string(names.size()) + " dimensions",
                 "Correct its metadata, or give --spacing and --origin");
  }
  if (!unread) set_place(transform, units, result.meaning);
  return result;
}

// Returns the name of each image, or its number from 1.
std::vector<std::string> names_of(const Json& images) {
  std::vector<std::string> names;
  if (!images.is_array()) return names;
  for (const Json& image : images) {
    std::string text = member_name_from(text_in(image, "name"));
    if (names.size() == kMaxSourceMembers) break;
    names.push_back(text.empty() ? std::to_string(names.size() + 1) : std::move(text));
  }
  return names;
}

std::size_t chosen_image(const std::vector<std::string>& names, const VolumeChoice& choice,
                         const fs::path& place) {
  if (choice.series.empty()) return 0;
  const auto number = parse_number<std::size_t>(choice.series);
  if (number && *number >= 1 && *number <= names.size()) return *number - 1;
  const auto named = std::find(names.begin(), names.end(), choice.series);
  if (named != names.end()) return static_cast<std::size_t>(named - names.begin());
  fail_reading(
      place, "it has " + std::to_string(names.size()) + " images, but none '" + choice.series + "'",
      "Choose an image with --series, by its number from 1 or its name");
}

}  // namespace

std::optional<OmeLevel> ome_level(const Json& attributes, const VolumeChoice& choice,
                                  const fs::path& place) {
  const Json images = member_of(ome_of(attributes), "multiscales");
  if (images.is_null()) return std::nullopt;
  const std::vector<std::string> names = names_of(images);
  const Json image = names.empty() ? Json() : images[chosen_image(names, choice, place)];
  Json levels = member_of(image, "datasets");
  if (!levels.is_array()) levels = Json::array();
  const std::int64_t wanted = choice.level.value_or(0);
  if (wanted < 0 || wanted >= static_cast<std::int64_t>(levels.size())) {
    fail_reading(place,
                 "it has " + std::to_string(levels.size()) + " levels, but no level " +
                     std::to_string(wanted),
                 "Choose one with --level; 0 is the finest");
  }
  std::stable_sort(levels.begin(), levels.end(),
                   [](const Json& a, const Json& b) { return voxel_of(a) < voxel_of(b); });
  OmeLevel level = described(image, levels[static_cast<std::size_t>(wanted)], choice, place);
  level.images = names;
  return level;
}

std::vector<std::string> ome_images(const ZarrContainer& container, const std::string& group) {
  const std::string prefix = key_prefix_of(group);
  const Json ome = ome_of(container.attributes(group));
  std::vector<std::string> images;
  const auto add = [&](const std::string& path) {
    const Json inside = ome_of(container.attributes(prefix + path));
    if (images.size() < kMaxSourceMembers && !member_of(inside, "multiscales").is_null()) {
      images.push_back(prefix + path);
    }
  };
  if (!member_of(ome, "bioformats2raw.layout").is_null()) {
    const Json listed = member_of(ome_of(container.attributes(prefix + "OME")), "series");
    for (const Json& path : listed.is_array() ? listed : Json::array()) {
      if (path.is_string()) add(path.get<std::string>());
    }
    for (bool is_found = !listed.is_array(); is_found;) {  // Numbered from 0.
      const std::size_t before = images.size();
      add(std::to_string(before));
      is_found = images.size() > before;
    }
  }
  const Json wells = member_of(member_of(ome, "plate"), "wells");
  for (const Json& well : wells.is_array() ? wells : Json::array()) {
    const std::string path = text_in(well, "path");
    const Json inside = ome_of(container.attributes(prefix + path));
    const Json fields = member_of(member_of(inside, "well"), "images");
    for (const Json& field : fields.is_array() ? fields : Json::array()) {
      add(path + "/" + text_in(field, "path"));
    }
  }
  return images;
}

}  // namespace multitetra

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxImages = 10'000;
constexpr const char* kInfo = "/DataSetInfo";

// "/DataSet/ResolutionLevel 0/TimePoint 0/Channel 0/Data"
struct ImarisPlace {
  std::int64_t level = 0;
  std::int64_t time = 0;
  std::int64_t channel = 0;

  [[nodiscard]] std::string times() const {
    return "/DataSet/ResolutionLevel " + std::to_string(level);
  }
  [[nodiscard]] std::string channels() const {
    return times() + "/TimePoint " + std::to_string(time);
  }
  [[nodiscard]] std::string group() const {
    return channels() + "/Channel " + std::to_string(channel);
  }
};

std::optional<ImarisPlace> place_of(const std::string& array) {
  const std::vector<std::string_view> parts = split(array, '/');
  const auto number = [&](std::size_t part, std::string_view prefix) {
    return parts[part].starts_with(prefix)
               ? parse_number<std::int64_t>(parts[part].substr(prefix.size()))
               : std::nullopt;
  };
  if (parts.size() != 6 || parts[1] != "DataSet" || parts[5] != "Data") return std::nullopt;
  const auto level = number(2, "ResolutionLevel ");
  const auto time = number(3, "TimePoint ");
  const auto channel = number(4, "Channel ");
  if (!level || !time || !channel) return std::nullopt;
  return ImarisPlace{.level = *level, .time = *time, .channel = *channel};
}

// Texts are arrays of characters.
std::string imaris_text(const ArrayContainer& file, const std::string& object,
                        const std::string& attribute) {
  std::string text;
  for (const std::string& part : file.texts(object, attribute.c_str())) text += part;
  return text;
}

std::optional<double> imaris_number(const ArrayContainer& file, const std::string& object,
                                    const std::string& attribute) {
  const std::string text = imaris_text(file, object, attribute);
  std::string_view rest = text;
  return take_number<double>(rest);
}

// Returns how many members "NAME 0", "NAME 1", ... a group has.
std::int64_t count_of(const ArrayContainer& file, const std::string& group,
                      const std::string& name) {
  const std::vector<std::string> all = file.children(group);
  std::size_t count = 0;
  while (count < kMaxImages &&
         std::ranges::find(all, name + " " + std::to_string(count)) != all.end())
    ++count;
  return static_cast<std::int64_t>(count);
}

std::int64_t chosen_of(const ArrayContainer& file, const std::string& name, std::int64_t count,
                       std::optional<std::int64_t> wanted, bool takes_first) {
  return chosen_entry(file.file(),
                      {.count = count,
                       .several = "it has " + std::to_string(count) + " " + name + "s",
                       .remedy = "Choose one with --" + name + ", from 0",
                       .missing = "it has no " + name},
                      wanted, takes_first);
}

std::vector<SourceField> channels_of(const ArrayContainer& file, const ImarisPlace& place) {
  std::vector<SourceField> fields;
  const std::int64_t count = count_of(file, place.channels(), "Channel");
  for (std::int64_t i = 0; count > 1 && i < count; ++i) {
    std::string name = member_name_from(
        imaris_text(file, std::string(kInfo) + "/Channel " + std::to_string(i), "Name"));
    if (name.empty()) name = "channel" + std::to_string(i);
    fields.push_back({.name = std::move(name), .channel = i});
  }
  return fields;
}

bool is_imaris(const ArrayContainer& file) {
  const std::vector<std::string> all = file.children(kInfo);
  return std::ranges::find(all, "Image") != all.end() &&
         !file.shape(ImarisPlace().group() + "/Data").empty();
}

}  // namespace

// Level, time and channel choose.
std::vector<std::string> imaris_arrays(const ArrayContainer& file, const VolumeChoice& choice) {
  if (!is_imaris(file)) return {};
  ImarisPlace place;
  place.level = chosen_of(file, "level", count_of(file, "/DataSet", "ResolutionLevel"),
                          choice.level.value_or(0), true);
  place.time = chosen_of(file, "time", count_of(file, place.times(), "TimePoint"), choice.time,
                         choice.first);
  place.channel = chosen_of(file, "channel", count_of(file, place.channels(), "Channel"),
                            choice.channel, choice.first);
  return {place.group() + "/Data"};
}

bool describe_imaris(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::optional<ImarisPlace> place = place_of(array);
  const std::vector<std::int64_t> shape = file.shape(array);
  if (!place || shape.size() != 3 || !is_imaris(file)) return false;
  meaning.has_levels = true;
  meaning.roles = {DimensionRole::kZ, DimensionRole::kY, DimensionRole::kX};
  meaning.times.count = count_of(file, place->times(), "TimePoint");
  meaning.channels = channels_of(file, *place);
  const std::string info = std::string(kInfo) + "/Image";
  StatedNumbers origin = kNotStated;
  StatedNumbers steps = kNotStated;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // The dataset may be padded.
    const auto all = static_cast<double>(shape[2 - axis]);
    const double size =
        imaris_number(file, place->group(), std::string("ImageSize") + "XYZ"[axis]).value_or(all);
    if (!(size >= 1 && size <= all)) {
      fail_damaged(file.file(), "its image is larger than its dataset");
    }
    meaning.sides[axis] = static_cast<std::int64_t>(size);
    const auto low = imaris_number(file, info, "ExtMin" + std::to_string(axis));
    const auto high = imaris_number(file, info, "ExtMax" + std::to_string(axis));
    if (!low || !high || !(*high > *low)) continue;
    steps[axis] = (*high - *low) / std::floor(size);
    origin[axis] = *low + *steps[axis] / 2;  // The center of a voxel.
  }
  set_box_axes(meaning.header, origin, steps);
  meaning.header.meaning.length_unit = unit_from(imaris_text(file, info, "Unit"));
  return true;
}

}  // namespace multitetra

#include "server/volume/formats/zarr/detail/zarr_contents.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/base/json.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

// Returns an element of an object; null if it is not there.
Json element(const Json& object, const char* key) {
  return object.is_object() ? object.value(key, Json()) : Json();
}

// Returns the attributes of OME-Zarr, which its later versions nest.
const Json& ome_attributes(const Json& attributes) {
  return attributes.contains("ome") ? attributes.at("ome") : attributes;
}

std::optional<double> label_value_of(const Json& entry) {
  const Json value = element(entry, "label-value");
  return value.is_number_integer() ? std::optional(value.get<double>()) : std::nullopt;
}

// Parses "00FF00", also with '#' in front.
std::optional<std::uint32_t> omero_color(std::string text) {
  if (!text.starts_with('#')) text.insert(0, "#");
  return color_from(text);
}

// Returns a number as text.
std::string number_text(const Json& value) {
  return value.is_number() ? json_text(value) : std::string("no number");
}

// Returns the list of channels of "omero".
Json omero_channels(const Json& attributes) {
  return element(element(ome_attributes(attributes), "omero"), "channels");
}

}  // namespace

std::vector<SourceField> zarr_channels(const nlohmann::json& attributes, std::int64_t count) {
  const Json channels = omero_channels(attributes);
  std::vector<SourceField> fields;
  for (std::int64_t i = 0; i < std::min<std::int64_t>(count, kMaxSourceMembers); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Json channel = channels.is_array() && at < channels.size() ? channels[at] : Json();
    const Json label = element(channel, "label");
    std::string name = label.is_string() ? member_name_from(label.get<std::string>()) : "";
    if (name.empty()) name = "channel" + std::to_string(i);
    const Json color = element(channel, "color");
    fields.push_back(
        {.name = std::move(name),
         .channel = i,
         .color = color.is_string() ? omero_color(color.get<std::string>()) : std::nullopt});
  }
  return fields;
}

std::optional<DisplayWindow> zarr_window(const nlohmann::json& attributes, std::int64_t channel,
                                         const std::filesystem::path& place,
                                         std::vector<std::string>& notices) {
  const Json channels = omero_channels(attributes);
  const auto at = static_cast<std::size_t>(channel);
  if (!channels.is_array() || at >= channels.size()) return std::nullopt;
  const Json window = element(channels[at], "window");
  const Json start = element(window, "start");
  const Json end = element(window, "end");
  if (start.is_null() && end.is_null()) return std::nullopt;
  if (start.is_number() && end.is_number()) {
    const DisplayWindow found{.low = start.get<double>(), .high = end.get<double>()};
    if (is_valid(found)) return found;
  }
  notices.push_back("'" + place.string() + "': the window of channel " + std::to_string(channel) +
                    " from " + number_text(start) + " to " + number_text(end) +
                    " is ignored; it must be two numbers, the smaller first.");
  return std::nullopt;
}

std::vector<SourceLabel> zarr_labels(const nlohmann::json& attributes) {
  const Json image = element(ome_attributes(attributes), "image-label");
  std::map<double, Label> labels;
  const auto visit = [&](const char* list, const auto& add) {
    const Json entries = element(image, list);
    if (!entries.is_array()) return;
    for (const Json& entry : entries) {
      const auto value = label_value_of(entry);
      if (!value || labels.size() >= kMaxSourceMembers) continue;
      Label& label = labels[*value];
      label.value = *value;
      add(entry, label);
    }
  };
  visit("colors", [](const Json& entry, Label& label) {
    const Json rgba = entry.value("rgba", Json());
    if (!rgba.is_array() || rgba.size() < 3) return;
    std::uint32_t color = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const bool is_byte = rgba[i].is_number_unsigned() && rgba[i].get<std::uint64_t>() <= 255;
      if (!is_byte) return;
      color = color << 8 | rgba[i].get<std::uint32_t>();
    }
    label.color = color;
  });
  visit("properties", [](const Json& entry, Label& label) {
    for (const char* key : {"name", "label", "label-name", "class"}) {
      const Json text = entry.value(key, Json());
      if (text.is_string() && label.name.empty())
        label.name = member_name_from(text.get<std::string>());
    }
  });
  std::vector<SourceLabel> list;
  for (const auto& [value, label] : labels) {
    if (!check_member({.series = "labels", .label = label})) continue;
    list.push_back({.label = label, .stored = value});
  }
  return list;
}

}  // namespace multitetra

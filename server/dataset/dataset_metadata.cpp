#include "server/dataset/dataset_metadata.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/json.hpp"
#include "server/dataset/detail/statistics.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

// Reads the fields of one JSON object. Records the first error; all later fields read as zero, so
// callers check once at the end.
class Fields {
 public:
  Fields(const Json& object, std::string& failure) : object_(object), failure_(failure) {}

  const Json& at(const char* key) {
    static const Json kNothing;
    if (!object_.is_object() || !object_.contains(key)) {
      add_error(key, "is missing");
      return kNothing;
    }
    return object_.at(key);
  }
  std::string text(const char* key) {
    const Json& value = at(key);
    if (value.is_string()) return value.get<std::string>();
    add_error(key, "is not a string");
    return {};
  }
  // Optional fields.
  std::string optional_text(const char* key) { return has(key) ? text(key) : std::string(); }
  std::optional<double> optional_number(const char* key) {
    return has(key) ? std::optional(number(key)) : std::nullopt;
  }
  [[nodiscard]] bool has(const char* key) const {
    return object_.is_object() && object_.contains(key);
  }
  double number(const char* key) { return number(key, at(key)); }
  std::uint64_t count(const char* key) { return count(key, at(key)); }
  std::int32_t integer(const char* key) {
    const std::uint64_t value = count(key, at(key));
    if (value > std::numeric_limits<std::int32_t>::max()) add_error(key, "is too large");
    return static_cast<std::int32_t>(value & 0x7FFFFFFFu);
  }
  std::optional<double> number_or_null(const char* key) {
    const Json& value = at(key);
    if (value.is_null()) return std::nullopt;
    return number(key, value);
  }
  std::vector<double> numbers(const char* key) {
    std::vector<double> values;
    for (const Json& value : list(key)) values.push_back(number(key, value));
    return values;
  }
  std::vector<std::uint64_t> counts(const char* key) {
    std::vector<std::uint64_t> values;
    for (const Json& value : list(key)) values.push_back(count(key, value));
    return values;
  }
  Vec3 vector(const char* key, const Json& value) {
    Vec3 result{};
    if (!value.is_array() || value.size() != 3) {
      add_error(key, "must have three numbers");
      return result;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) result[axis] = number(key, value[axis]);
    return result;
  }
  Affine affine(const char* key) {
    const Json& value = at(key);
    Affine map;
    if (!value.is_array() || value.size() != 4) {
      add_error(key, "must have three columns and a translation");
      return map;
    }
    for (std::size_t column = 0; column < 3; ++column) {
      map.columns[column] = vector(key, value[column]);
    }
    map.translation = vector(key, value[3]);
    return map;
  }
  void add_error(const std::string& key, const std::string& what) {
    if (failure_.empty()) failure_ = "field \"" + key + "\" " + what;
  }

 private:
  const Json& list(const char* key) {
    static const Json kEmpty = Json::array();
    const Json& value = at(key);
    if (value.is_array()) return value;
    add_error(key, "is not an array");
    return kEmpty;
  }
  double number(const char* key, const Json& value) {
    if (value.is_number()) return value.get<double>();
    add_error(key, "is not a number");
    return 0;
  }
  std::uint64_t count(const char* key, const Json& value) {
    if (value.is_number_unsigned()) return value.get<std::uint64_t>();
    add_error(key, "is not a non-negative integer");
    return 0;
  }

  const Json& object_;
  std::string& failure_;
};

Json to_json(const Affine& map) {
  return {map.columns[0], map.columns[1], map.columns[2], map.translation};
}

// Omits empty fields.
Json to_json(const SeriesMember& member) {
  Json json = {{"series", member.series}};
  if (!member.field.empty()) json["field"] = member.field;
  if (member.time) json["time"] = *member.time;
  if (!member.time_unit.empty()) json["time_unit"] = member.time_unit;
  if (member.color) json["color"] = color_text(*member.color);
  if (!member.label) return json;
  json["label"] = {{"value", member.label->value}};
  if (!member.label->name.empty()) json["label"]["name"] = member.label->name;
  if (member.label->color) json["label"]["color"] = color_text(*member.label->color);
  return json;
}

std::optional<std::uint32_t> optional_color(Fields& fields) {
  if (!fields.has("color")) return std::nullopt;
  const auto color = color_from(fields.text("color"));
  if (!color) fields.add_error("color", "is not a color such as \"#dd8265\"");
  return color;
}

SeriesMember member_from(const Json& json, std::string& failure) {
  Fields fields(json, failure);
  SeriesMember member{.series = fields.text("series"),
                      .field = fields.optional_text("field"),
                      .time = fields.optional_number("time"),
                      .time_unit = fields.optional_text("time_unit"),
                      .color = optional_color(fields)};
  if (!fields.has("label")) return member;
  Fields label(fields.at("label"), failure);
  member.label = {.value = label.number("value"),
                  .name = label.optional_text("name"),
                  .color = optional_color(label)};
  return member;
}

LabelVolume label_volume_from(const Json& json, const DatasetInfo& info, std::string& failure) {
  Fields fields(json, failure);
  LabelVolume volume{.samples = fields.count("samples"),
                     .surface_samples = fields.number("surface_samples")};
  if (!fields.has("least")) return volume;
  const Vec3 least = fields.vector("least", fields.at("least"));
  const Vec3 greatest = fields.vector("greatest", fields.at("greatest"));
  LabelExtent::Place place{.centroid = fields.vector("centroid", fields.at("centroid"))};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_inside = least[axis] >= 0 && least[axis] <= place.centroid[axis] &&
                           place.centroid[axis] <= greatest[axis] &&
                           greatest[axis] < info.dims[axis];
    if (!is_inside) {
      fields.add_error("label_volume", "is outside the samples");
      return volume;
    }
    place.least[axis] = static_cast<std::int32_t>(least[axis]);
    place.greatest[axis] = static_cast<std::int32_t>(greatest[axis]);
  }
  volume.place = place;
  return volume;
}

}  // namespace

std::string metadata_text(const DatasetMetadata& metadata) {
  const DatasetInfo& info = metadata.info;
  Json json = {
      {"name", info.name},
      {"dims", info.dims},
      {"type", name(info.type)},
      {"spacing", info.spacing},
      {"index_to_world", to_json(info.index_to_world)},
      {"min", info.min},
      {"max", info.max},
      {"void_samples", info.void_samples},
      {"outside", info.outside ? Json(*info.outside) : Json()},
      {"margin", info.margin},
      {"grid_exponent", info.grid_exponent},
      {"histogram",
       {{"low", info.histogram.low},
        {"high", info.histogram.high},
        {"counts", info.histogram.counts}}},
      {"suggested_isovalues", info.suggested_isovalues},
      {"source", {{"file", metadata.source.file}, {"digest", metadata.source.digest}}},
      {"program_version", metadata.program_version},
  };
  if (!metadata.source.options.empty()) json["source"]["options"] = metadata.source.options;
  const auto add_text = [&](const char* key, std::string_view text) {
    if (!text.empty()) json[key] = text;
  };
  add_text("space", name(info.meaning.space));
  add_text("length_unit", info.meaning.length_unit);
  add_text("value_unit", info.meaning.value_unit);
  add_text("geometry", name(info.meaning.geometry));
  add_text("assumed", info.meaning.assumed);
  if (info.member) json["member"] = to_json(*info.member);
  if (info.display_window) {
    json["display_window"] = {{"low", info.display_window->low},
                              {"high", info.display_window->high}};
  }
  if (metadata.label_volume) {
    json["label_volume"] = {{"samples", metadata.label_volume->samples},
                            {"surface_samples", metadata.label_volume->surface_samples}};
    if (const auto& place = metadata.label_volume->place) {
      json["label_volume"].update(
          {{"least", place->least}, {"greatest", place->greatest}, {"centroid", place->centroid}});
    }
  }
  return json_text(json);
}

Result<DatasetMetadata> parse_metadata(std::string_view text) {
  const auto damaged = [](const std::string& what) {
    return fail(ErrorCode::kDamagedData, "Section \"metadata\": " + what);
  };
  const Json json = parse_json(text);
  if (!json.is_object()) return damaged("it is not a JSON object.");

  std::string failure;
  Fields fields(json, failure);
  Fields source(fields.at("source"), failure);
  Fields histogram(fields.at("histogram"), failure);
  DatasetMetadata metadata;
  DatasetInfo& info = metadata.info;
  info.name = fields.text("name");
  const std::vector<std::uint64_t> dims = fields.counts("dims");
  for (std::size_t axis = 0; axis < 3 && axis < dims.size(); ++axis) {
    if (dims[axis] <= std::uint64_t{1} << kMaxLatticeBits) {
      info.dims[axis] = static_cast<std::int32_t>(dims[axis]);
    }
  }
  if (dims.size() != 3) fields.add_error("dims", "must have three numbers");
  const auto type = sample_type_from(fields.text("type"));
  if (!type) fields.add_error("type", "is not one of u8, i8, u16, i16, f32");
  info.type = type.value_or(SampleType::kU8);
  info.spacing = fields.vector("spacing", fields.at("spacing"));
  info.index_to_world = fields.affine("index_to_world");
  const auto space = world_space_from(fields.optional_text("space"));
  if (!space) fields.add_error("space", "is not LPS, RAS or empty");
  const auto geometry = geometry_basis_from(fields.optional_text("geometry"));
  if (!geometry) fields.add_error("geometry", "is not stated, partly or assumed");
  info.meaning = {.space = space.value_or(WorldSpace::kUnnamed),
                  .length_unit = fields.optional_text("length_unit"),
                  .value_unit = fields.optional_text("value_unit"),
                  .geometry = geometry.value_or(GeometryBasis::kUnknown),
                  .assumed = fields.optional_text("assumed")};
  info.min = fields.number("min");
  info.max = fields.number("max");
  info.void_samples = fields.count("void_samples");
  info.outside = fields.number_or_null("outside");
  info.margin = fields.integer("margin");
  info.grid_exponent = fields.integer("grid_exponent");
  info.histogram.low = histogram.number("low");
  info.histogram.high = histogram.number("high");
  info.histogram.counts = histogram.counts("counts");
  info.suggested_isovalues = fields.numbers("suggested_isovalues");
  if (fields.has("member")) info.member = member_from(fields.at("member"), failure);
  if (fields.has("display_window")) {
    Fields window(fields.at("display_window"), failure);
    info.display_window = {.low = window.number("low"), .high = window.number("high")};
    if (!is_valid(*info.display_window)) {
      fields.add_error("display_window", "is not from a smaller to a larger number");
    }
  }
  if (fields.has("label_volume")) {
    metadata.label_volume = label_volume_from(fields.at("label_volume"), info, failure);
    info.label_extent = metadata.label_volume->extent();
  }
  metadata.source = {.file = source.text("file"),
                     .digest = source.text("digest"),
                     .options = source.optional_text("options")};
  metadata.program_version = fields.text("program_version");
  if (!failure.empty()) return damaged(failure + ".");
  if (const auto checked = check_info(info); !checked) return damaged(checked.error().text);
  return metadata;
}

}  // namespace multitetra

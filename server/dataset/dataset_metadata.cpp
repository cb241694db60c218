#include "server/dataset/dataset_metadata.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/json.hpp"
#include "common/dataset/dataset_fields.hpp"
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
  // Returns the object that a field holds.
  Fields part(const char* key) { return {at(key), failure_}; }
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

SeriesMember member_from(Fields fields) {
  SeriesMember member{.series = fields.text("series"),
                      .field = fields.optional_text("field"),
                      .time = fields.optional_number("time"),
                      .time_unit = fields.optional_text("time_unit"),
                      .color = optional_color(fields)};
  if (!fields.has("label")) return member;
  Fields label = fields.part("label");
  member.label = {.value = label.number("value"),
                  .name = label.optional_text("name"),
                  .color = optional_color(label)};
  return member;
}

// ---- fields of DatasetInfo. Texts, windows and members that are empty are omitted.

template <typename Value>
void put(Json& json, const char* key, const Value& value) {
  json[key] = value;
}
void put(Json& json, const char* key, const std::string& text) {
  if (!text.empty()) json[key] = text;
}
void put(Json& json, const char* key, SampleType type) { json[key] = name(type); }
void put(Json& json, const char* key, WorldSpace space) {
  put(json, key, std::string(name(space)));
}
void put(Json& json, const char* key, GeometryBasis basis) {
  put(json, key, std::string(name(basis)));
}
void put(Json& json, const char* key, const Affine& map) { json[key] = to_json(map); }
void put(Json& json, const char* key, const std::optional<double>& value) {
  json[key] = value ? Json(*value) : Json();
}
void put(Json& json, const char* key, const std::optional<SeriesMember>& member) {
  if (member) json[key] = to_json(*member);
}
void put(Json& json, const char* key, const std::optional<DisplayWindow>& window) {
  if (window) json[key] = {{"low", window->low}, {"high", window->high}};
}
void put(Json& json, const char* key, const Histogram& histogram) {
  json[key] = {{"low", histogram.low}, {"high", histogram.high}, {"counts", histogram.counts}};
}

void get(Fields& fields, const char* key, std::string& text) { text = fields.optional_text(key); }
void get(Fields& fields, const char* key, double& value) { value = fields.number(key); }
void get(Fields& fields, const char* key, std::uint64_t& value) { value = fields.count(key); }
void get(Fields& fields, const char* key, std::int32_t& value) { value = fields.integer(key); }
void get(Fields& fields, const char* key, Vec3& vector) {
  vector = fields.vector(key, fields.at(key));
}
void get(Fields& fields, const char* key, Affine& map) { map = fields.affine(key); }
void get(Fields& fields, const char* key, std::vector<double>& values) {
  values = fields.numbers(key);
}
void get(Fields& fields, const char* key, std::optional<double>& value) {
  value = fields.number_or_null(key);
}
void get(Fields& fields, const char* key, std::array<std::int32_t, 3>& sides) {
  const std::vector<std::uint64_t> counts = fields.counts(key);
  for (std::size_t axis = 0; axis < 3 && axis < counts.size(); ++axis) {
    if (counts[axis] <= std::uint64_t{1} << kMaxLatticeBits) {
      sides[axis] = static_cast<std::int32_t>(counts[axis]);
    }
  }
  if (counts.size() != 3) fields.add_error(key, "must have three numbers");
}
void get(Fields& fields, const char* key, SampleType& type) {
  const auto known = sample_type_from(fields.text(key));
  if (!known) fields.add_error(key, "is not one of u8, i8, u16, i16, f32");
  type = known.value_or(SampleType::kU8);
}
void get(Fields& fields, const char* key, WorldSpace& space) {
  const auto known = world_space_from(fields.optional_text(key));
  if (!known) fields.add_error(key, "is not LPS, RAS or empty");
  space = known.value_or(WorldSpace::kUnnamed);
}
void get(Fields& fields, const char* key, GeometryBasis& basis) {
  const auto known = geometry_basis_from(fields.optional_text(key));
  if (!known) fields.add_error(key, "is not stated, partly or assumed");
  basis = known.value_or(GeometryBasis::kUnknown);
}
void get(Fields& fields, const char* key, std::optional<SeriesMember>& member) {
  if (fields.has(key)) member = member_from(fields.part(key));
}
void get(Fields& fields, const char* key, std::optional<DisplayWindow>& window) {
  if (!fields.has(key)) return;
  Fields ends = fields.part(key);
  window = {.low = ends.number("low"), .high = ends.number("high")};
  if (!is_valid(*window)) fields.add_error(key, "is not from a smaller to a larger number");
}
void get(Fields& fields, const char* key, Histogram& histogram) {
  Fields part = fields.part(key);
  histogram = {
      .low = part.number("low"), .high = part.number("high"), .counts = part.counts("counts")};
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
  Json json = {
      {"source", {{"file", metadata.source.file}, {"digest", metadata.source.digest}}},
      {"program_version", metadata.program_version},
  };
  if (!metadata.source.options.empty()) json["source"]["options"] = metadata.source.options;
  visit_dataset_fields(metadata.info, [&json](const DatasetField& field, const auto& value) {
    put(json, field.name, value);
  });
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
  Fields source = fields.part("source");
  DatasetMetadata metadata;
  DatasetInfo& info = metadata.info;
  static_cast<void>(fields.text("name"));  // Not optional, unlike other texts.
  visit_dataset_fields(
      info, [&fields](const DatasetField& field, auto& value) { get(fields, field.name, value); });
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
  if (!info.missing.empty() && info.missing != kMissingErrors) {
    return damaged("missing \"" + info.missing + "\" is unknown to this program.");
  }
  return metadata;
}

}  // namespace multitetra

#include "server/routes/openapi.hpp"

#include <array>
#include <map>
#include <string_view>
#include <type_traits>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/base/json.hpp"
#include "common/base/text.hpp"
#include "common/dataset/dataset_fields.hpp"
#include "common/request/surface_query.hpp"
#include "server/routes/detail/mesh_query.hpp"
#include "server/routes/detail/slice_query.hpp"
#include "server/routes/detail/thumbnail_query.hpp"

namespace multitetra {

extern const std::string_view kOpenApiText;  // openapi.json, embedded by the build.

namespace {

using Json = nlohmann::ordered_json;

// Returns the schema of values of one syntax: the alternatives "x|y|z", or a kind of value.
Json schema_of(std::string_view syntax) {
  static const std::map<std::string_view, Json> kKinds = {
      {"", {{"type", "string"}, {"enum", {"on", "off", "true", "false"}}}},
      {"on|off", {{"type", "string"}, {"enum", {"on", "off", "true", "false"}}}},
      {"NUMBER", {{"type", "number"}, {"minimum", 0}}},
      {"VOXELS", {{"type", "number"}, {"minimum", 0}}},
      {"a number", {{"type", "number"}}},
      {"a finite number", {{"type", "number"}}},
      {"a number greater than 0", {{"type", "number"}, {"exclusiveMinimum", 0}}},
      {"a number of pixels, 2 or more", {{"type", "integer"}, {"minimum", 2}}},
      {"R", {{"type", "integer"}, {"minimum", 1}, {"maximum", 8}}},
      {"BITS", {{"type", "integer"}}},
      {"BYTES", {{"type", "string"}, {"pattern", "^[0-9.]+[A-Za-z]*$"}, {"examples", {"2MiB"}}}},
      {"COUNT", {{"type", "string"}, {"pattern", "^[0-9.]+[A-Za-z]*$"}, {"examples", {"300k"}}}},
      {"RRGGBB", {{"type", "string"}, {"pattern", "^[0-9a-fA-F]{6}$"}}},
      {"a color, RRGGBB", {{"type", "string"}, {"pattern", "^[0-9a-fA-F]{6}$"}}},
      {"SAMPLES",
       {{"anyOf",
         {{{"type", "number"}, {"minimum", 0}},
          {{"type", "string"}, {"enum", Json::array({"largest"})}}}}}}};
  if (const auto kind = kKinds.find(syntax); kind != kKinds.end()) return kind->second;
  Json schema = {{"type", "string"}};
  if (syntax.find('|') != std::string_view::npos) schema["enum"] = split(syntax, '|');
  return schema;
}

template <typename Field>
Json parameter_of(const Field& field) {
  Json parameter = {{"name", field.name}, {"in", "query"}};
  if constexpr (requires { field.is_required; }) {
    if (field.is_required) parameter["required"] = true;
  }
  parameter["description"] = std::string(field.help) + ".";
  if (field.is_repeatable) {
    parameter["schema"] = {{"type", "array"}, {"items", {{"type", "string"}}}};
    parameter["explode"] = true;
    return parameter;
  }
  Json& schema = parameter["schema"] = schema_of(field.value_syntax);
  if (field.default_text.empty()) return parameter;
  const bool is_text = schema.value("type", "") == "string";
  schema["default"] = is_text ? Json(field.default_text) : Json(parse_json(field.default_text));
  return parameter;
}

template <typename Fields>
void add_parameters(Json& list, const Fields& fields) {
  for (const auto& field : fields) list.push_back(parameter_of(field));
}

void add_table(Json& list, const std::string& name) {
  if (name == "isosurface") {
    add_parameters(list, request_fields());
    add_parameters(list, file_fields());
  } else if (name == "slice") {
    add_parameters(list, slice_fields());
  } else if (name == "probe") {
    add_parameters(list, probe_fields());
  } else if (name == "thumbnail") {
    add_parameters(list, thumbnail_fields());
  }
}

// The schemas of the fields of DatasetInfo, as in json_of().
template <typename Value>
Json field_schema(const Value&) {
  return {{"type", std::is_integral_v<Value> ? "integer" : "number"}};
}
Json field_schema(const std::string&) { return {{"type", {"string", "null"}}}; }
Json field_schema(SampleType) {
  Json schema = {{"type", "string"}};
  for (int i = 0; i <= static_cast<int>(SampleType::kF32); ++i) {
    schema["enum"].push_back(name(static_cast<SampleType>(i)));
  }
  return schema;
}
Json field_schema(WorldSpace) {
  return {{"type", {"string", "null"}}, {"enum", {"LPS", "RAS", nullptr}}};
}
Json field_schema(GeometryBasis) {
  return {{"type", {"string", "null"}}, {"enum", {"stated", "partly", "assumed", nullptr}}};
}
Json field_schema(const std::array<std::int32_t, 3>&) {
  return {{"type", "array"},
          {"items", {{"type", "integer"}, {"minimum", 1}}},
          {"minItems", 3},
          {"maxItems", 3}};
}
Json field_schema(const std::vector<double>&) {
  return {{"type", "array"}, {"items", {{"type", "number"}}}};
}
Json field_schema(const std::optional<double>&) { return {{"type", {"number", "null"}}}; }
Json schema_reference(const char* name) {
  return {{"$ref", std::string("#/components/schemas/") + name}};
}
Json field_schema(const Vec3&) { return schema_reference("Vector"); }
Json field_schema(const Affine&) { return schema_reference("Affine"); }
Json field_schema(const Histogram&) { return schema_reference("Histogram"); }
Json field_schema(const std::optional<SeriesMember>&) { return schema_reference("SeriesMember"); }
Json field_schema(const std::optional<DisplayWindow>&) { return schema_reference("Window"); }

Json dataset_schema() {
  Json schema = {{"type", "object"}, {"required", Json::array()}, {"properties", Json::object()}};
  const DatasetInfo any;
  visit_dataset_fields(any, [&schema](const DatasetField& field, const auto& value) {
    const std::string_view name = field.name;
    Json& property = schema["properties"][field.name] = field_schema(value);
    if (name == "name") property["type"] = "string";  // Never empty.
    if (!field.help.empty()) property["description"] = field.help;
    if (name != "histogram") schema["required"].push_back(name);
  });
  return schema;
}

Json with_error(const Json& text) {
  return {
      {"description", text},
      {"content", {{"application/json", {{"schema", {{"$ref", "#/components/schemas/Error"}}}}}}}};
}

Json part_of(Json whole) {
  whole["description"] = "The requested range.";
  whole["headers"] = {{"ETag", {{"$ref", "#/components/headers/ETag"}}}};
  return whole;
}

const char* shared_response(int status) {
  static const std::map<int, const char*> kNames = {
      {304, "NotModified"}, {400, "BadRequest"},  {401, "Unauthorized"},
      {403, "Forbidden"},   {404, "NotFound"},    {416, "RangeNotSatisfiable"},
      {429, "TooMany"},     {500, "ServerError"}, {503, "Unavailable"}};
  return kNames.at(status);
}

// Returns the node with what its keys with $ stand for, except $ref.
Json expanded(const Json& node) {
  if (node.is_array()) {
    Json list = Json::array();
    for (const Json& item : node) {
      if (item.is_object() && item.contains("$parameters")) {
        add_table(list, item["$parameters"]);
      } else {
        list.push_back(expanded(item));
      }
    }
    return list;
  }
  if (!node.is_object()) return node;
  if (node.contains("$error")) return with_error(node["$error"]);
  if (node.contains("$dataset")) return dataset_schema();
  Json made = Json::object();
  for (const auto& [key, value] : node.items()) {
    if (key == "$shared") {
      for (const int status : value) {
        made[std::to_string(status)] = {
            {"$ref", std::string("#/components/responses/") + shared_response(status)}};
      }
    } else if (value.is_object() && value.contains("$part_of")) {
      made[key] = part_of(expanded(node.at(value["$part_of"].get<std::string>())));
    } else {
      made[key] = expanded(value);
    }
  }
  return made;
}

}  // namespace

const std::string& api_description() {
  static const std::string kText = json_text(expanded(Json::parse(kOpenApiText)), 1) + "\n";
  return kText;
}

}  // namespace multitetra

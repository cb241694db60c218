#include "server/volume/formats/zarr/detail/zarr_container.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "server/volume/formats/zarr/detail/chunked_slices.hpp"
#include "server/volume/formats/zarr/detail/zarr_json.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxArrays = 10'000;

// Some buckets deny access to missing objects. Detects this by a name that cannot exist; only then
// does denied access to metadata mean that they are missing.
bool refuses_what_is_missing(ObjectStore& store) {
  try {
    return text_of(store, "multitetra/nonexistent").has_value();
  } catch (const StoreAccessDenied&) {
    return true;
  }
}

// Returns a number of JSON, or one that JSON does not have as its name.
std::optional<double> number_of(const Json& value) {
  if (value.is_number()) return value.get<double>();
  if (value == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (value == "Infinity") return std::numeric_limits<double>::infinity();
  if (value == "-Infinity") return -std::numeric_limits<double>::infinity();
  return std::nullopt;
}

// xarray writes the float that fills an array of Zarr 3 as base64 of the eight bytes of a double.
std::optional<double> number_in_base64(const Json& value) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr std::size_t kCount = 11;
  const std::string text = value.is_string() ? value.get<std::string>() : std::string();
  if (text.size() != kCount + 1 || text.back() != '=') return std::nullopt;
  std::array<std::byte, 9> bytes{};
  for (std::size_t bit = 0; bit < 6 * kCount; ++bit) {
    const std::size_t digit = kDigits.find(text[bit / 6]);
    if (digit == std::string_view::npos) return std::nullopt;
    bytes[bit / 8] |= static_cast<std::byte>((digit >> (5 - bit % 6) & 1) << (7 - bit % 8));
  }
  return number_from(StoredType::kF64, bytes.data());
}

}  // namespace

std::string key_prefix_of(const std::string& path) {
  const std::size_t begin = path.find_first_not_of('/');
  if (begin == std::string::npos) return {};
  return path.substr(begin, path.find_last_not_of('/') + 1 - begin) + "/";
}

std::optional<std::string> ZarrContainer::text_at(const std::string& key) const {
  try {
    return text_of(*store_, key);
  } catch (const StoreAccessDenied&) {
    if (refuses_what_is_missing(*store_)) return std::nullopt;
    throw;
  }
}

Json ZarrContainer::json_at(const std::string& key) const {
  const std::optional<std::string> text = text_at(key);
  if (!text) return {};
  Json json = parse_zarr_json(*text);
  if (json.is_discarded()) {
    fail_reading(store_->place(key), "it is not JSON", "Check the program that wrote it");
  }
  return json;
}

// From zarr.json (Zarr 3), .zattrs (Zarr 2) or attributes.json (N5).
const Json& ZarrContainer::attributes(const std::string& path) const {
  const std::string prefix = key_prefix_of(path);
  const auto [found, is_new] = attributes_.try_emplace(prefix);
  if (!is_new) return found->second;
  const Json three = json_at(prefix + "zarr.json");
  Json attributes = three.is_object() ? three.value("attributes", Json::object()) : Json();
  if (!three.is_object()) attributes = json_at(prefix + ".zattrs");
  if (!attributes.is_object()) attributes = json_at(prefix + "attributes.json");
  return found->second = std::move(attributes);
}

std::optional<ArrayLayout> ZarrContainer::layout(const std::string& path) const {
  const std::string prefix = key_prefix_of(path);
  const auto parsed = [&](const std::string& key, const auto& parse) -> std::optional<ArrayLayout> {
    const std::optional<std::string> text = text_at(key);
    if (!text) return std::nullopt;
    auto layout = parse(*text);
    if (layout) return *std::move(layout);
    fail_reading(store_->place(key), layout.error().text, "Save the array in another way");
  };
  const Json three = json_at(prefix + "zarr.json");
  if (three.is_object() && three.value("node_type", Json()) == "array") {
    return parsed(prefix + "zarr.json", parse_zarr_3);
  }
  if (auto two = parsed(prefix + ".zarray", parse_zarr_2)) return two;
  const Json& n5 = attributes(path);
  if (n5.is_object() && n5.contains("dimensions"))
    return parsed(prefix + "attributes.json", parse_n5);
  return std::nullopt;
}

std::vector<std::string> ZarrContainer::arrays() const {
  std::vector<std::string> found;
  const Json two = json_at(".zmetadata");
  if (two.is_object() && two.value("metadata", Json()).is_object()) {
    for (const auto& [key, value] : two["metadata"].items()) {
      if (key.ends_with("/.zarray")) found.push_back(key.substr(0, key.size() - 8));
    }
  }
  const Json three = json_at("zarr.json");
  const Json consolidated =
      three.is_object() ? three.value(Json::json_pointer("/consolidated_metadata/metadata"), Json())
                        : Json();
  for (const auto& [key, value] : consolidated.items()) {
    if (value.is_object() && value.value("node_type", Json()) == "array") found.push_back(key);
  }
  if (found.empty()) find_arrays("", 0, found);
  std::sort(found.begin(), found.end());
  std::erase_if(found, [&](const std::string& array) {
    const std::vector<std::int64_t> sides = shape(array);
    return std::count_if(sides.begin(), sides.end(), [](std::int64_t n) { return n > 1; }) < 2;
  });
  return found;
}

void ZarrContainer::find_arrays(const std::string& group, int depth,
                                std::vector<std::string>& found) const {
  constexpr int kDeepest = 6;
  for (const std::string& name : children(group)) {
    const std::string path = key_prefix_of(group) + name;
    if (found.size() >= kMaxArrays) return;
    const bool is_array = !shape(path).empty();
    if (is_array) found.push_back(path);
    if (!is_array && depth < kDeepest) find_arrays(path, depth + 1, found);
  }
}

std::vector<std::string> ZarrContainer::children(const std::string& group) const {
  std::vector<std::string> names = store_->names(key_prefix_of(group));
  std::erase_if(names, [](const std::string& name) {
    return name.starts_with('.') || name == "zarr.json" || name == "attributes.json";
  });
  return names;
}

std::vector<std::int64_t> ZarrContainer::shape(const std::string& array) const {
  try {
    const std::optional<ArrayLayout> found = layout(array);
    return found ? found->shape : std::vector<std::int64_t>();
  } catch (const VolumeFileError& problem) {  // An array of texts, for example.
    if (unsupported_.empty()) unsupported_ = problem.what();
    return {};
  }
}

std::optional<StoredType> ZarrContainer::type(const std::string& array) const {
  const std::optional<ArrayLayout> found = layout(array);
  return found ? std::optional(found->type) : std::nullopt;
}

std::vector<double> ZarrContainer::values(const std::string& array) const {
  std::optional<ArrayLayout> found = layout(array);
  if (!found || found->shape.size() != 1 || found->shape[0] < 1 ||
      found->shape[0] > static_cast<std::int64_t>(kMaxValues))
    return {};
  const StoredType type = found->type;
  std::vector<double> values(static_cast<std::size_t>(found->shape[0]));
  std::vector<std::byte> bytes(values.size() * bytes_of(type));
  const auto line = chunked_slices(store_, key_prefix_of(array), *std::move(found),
                                   {.axes = {0, std::nullopt, std::nullopt}, .at = {0}});
  line->read(0, 1, bytes.data());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = number_from(type, bytes.data() + i * bytes_of(type));
  }
  return values;
}

std::vector<double> ZarrContainer::numbers(const std::string& object, const char* attribute) const {
  const Json& all = attributes(object);
  const Json value = all.is_object() ? all.value(attribute, Json()) : Json();
  std::vector<double> numbers;
  if (const auto number = number_of(value)) return {*number};
  if (std::string_view(attribute) == "_FillValue") {
    if (const auto number = number_in_base64(value)) return {*number};
  }
  if (!value.is_array()) return {};
  for (const Json& element : value) {
    const auto number = number_of(element);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<std::string> ZarrContainer::texts(const std::string& object,
                                              const char* attribute) const {
  const Json& all = attributes(object);
  Json value = all.is_object() ? all.value(attribute, Json()) : Json();
  if (!value.is_array()) value = Json::array({value});
  std::vector<std::string> texts;
  for (const Json& element : value) {
    if (!element.is_string()) return {};
    texts.push_back(element.get<std::string>());
  }
  return texts;
}

std::vector<std::string> ZarrContainer::dimension_names(const std::string& array) const {
  const std::optional<ArrayLayout> found = layout(array);
  if (!found) return {};
  // xarray names the dimensions of Zarr 2 by an attribute.
  std::vector<std::string> names = found->dimension_names;
  if (names.empty()) names = texts(array, "_ARRAY_DIMENSIONS");
  names.resize(found->shape.size());
  return names;
}

std::string ZarrContainer::coordinates(const std::string& array, std::size_t dimension) const {
  const std::vector<std::string> names = dimension_names(array);
  if (dimension >= names.size() || names[dimension].empty()) return {};
  const std::string prefix = key_prefix_of(group_of(array));
  const std::string path = prefix + names[dimension];
  return shape(path).size() == 1 && path != array ? path : std::string();
}

}  // namespace multitetra

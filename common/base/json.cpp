#include "common/base/json.hpp"

namespace multitetra {
namespace {

template <typename Json>
std::string text_of_json(const Json& json, int indent) {
  return json.dump(indent, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

}  // namespace

nlohmann::json parse_json(std::string_view text) {
  return nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
}

std::string json_text(const nlohmann::json& json, int indent) { return text_of_json(json, indent); }
std::string json_text(const nlohmann::ordered_json& json, int indent) {
  return text_of_json(json, indent);
}

}  // namespace multitetra

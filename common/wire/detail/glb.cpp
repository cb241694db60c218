#include "common/wire/detail/glb.hpp"

#include <cassert>
#include <cstdint>
#include <limits>
#include <system_error>

#include "common/image/srgb.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {
namespace {

void append_u32(std::string& bytes, std::uint64_t value) {
  for (int byte = 0; byte < 4; ++byte) {
    bytes.push_back(static_cast<char>(value >> (8 * byte) & 0xFF));
  }
}

}  // namespace

nlohmann::json empty_gltf() {
  return {{"asset", {{"version", "2.0"}, {"generator", "Multi-Tetra " MULTITETRA_VERSION}}},
          {"scene", 0},
          {"scenes", nlohmann::json::array({nlohmann::json::object()})}};
}

std::array<double, 3> color_of(const SurfaceName& name, std::size_t number) {
  if (!name.color) return part_color(number);
  const Light light = linear_light(unpacked(*name.color));
  return {light[0], light[1], light[2]};
}

nlohmann::json surface_material(const std::array<double, 3>& color) {
  return {{"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {color[0], color[1], color[2], 1.0}},
            {"metallicFactor", 0.0},
            {"roughnessFactor", 0.6}}}};
}

void name_node(nlohmann::json& node, const SurfaceName& name) {
  if (!name.text.empty()) node["name"] = name.text;
  if (name.label) node["extras"]["label"] = static_cast<std::int64_t>(*name.label);
}

std::string glb_beginning(const nlohmann::json& json, std::size_t binary) {
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  constexpr std::uint32_t kBinaryChunk = 0x004E4942;
  assert(binary % 4 == 0);
  std::string text = json_text(json);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t total = 20 + text.size() + (binary == 0 ? 0 : 8 + binary);
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw std::system_error(std::make_error_code(std::errc::file_too_large),
                            "A GLB file has at most 4 GiB; this mesh needs " +
                                std::to_string(total) + " bytes. PLY files have no such limit");
  }
  std::string file = "glTF";
  file.reserve(total);
  append_u32(file, 2);
  append_u32(file, total);
  append_u32(file, text.size());
  append_u32(file, kJsonChunk);
  file += text;
  if (binary == 0) return file;
  append_u32(file, binary);
  append_u32(file, kBinaryChunk);
  return file;
}

}  // namespace multitetra

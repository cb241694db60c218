// Binary glTF 2.0: a JSON chunk that describes the binary chunk, possibly with Draco meshes.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

#include "common/base/affine.hpp"
#include "common/base/json.hpp"
#include "common/image/stored_type.hpp"
#include "common/wire/detail/instances.hpp"
#include "common/wire/detail/mesh_bytes.hpp"
#include "common/wire/draco_mesh.hpp"

namespace multitetra {
namespace {

using nlohmann::json;

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";
// Extensions that a file may require.
constexpr std::array<std::string_view, 4> kKnownExtensions = {
    kDracoExtension, kMeshoptExtension, "KHR_mesh_quantization", "KHR_materials_unlit"};

// From 5120 on.
constexpr std::array<std::optional<StoredType>, 7> kComponentTypes = {
    StoredType::kI8, StoredType::kU8,  StoredType::kI16, StoredType::kU16,
    std::nullopt,    StoredType::kU32, StoredType::kF32};

TriangleMesh decoded_draco(std::string_view bytes, std::optional<std::uint32_t> position_id) {
  auto mesh = decode_draco_mesh(bytes, position_id);
  if (!mesh) throw MeshFileError(mesh.error().text);
  return {.vertices = std::move(mesh->positions), .triangles = std::move(mesh->triangles)};
}

// Reads a non-negative integer.
std::size_t whole(const json& value) {
  if (!value.is_number_unsigned())
    throw MeshFileError(
        "its JSON has a value that is not a non-negative integer where one is required");
  return value.get<std::size_t>();
}
std::size_t whole_or(const json& object, const char* key, std::size_t otherwise) {
  return object.contains(key) ? whole(object[key]) : otherwise;
}

const json& element(const json& document, const char* array, std::size_t index) {
  if (!document.contains(array) || !document[array].is_array() || index >= document[array].size()) {
    throw MeshFileError("its JSON refers to a missing element of '" + std::string(array) + "'");
  }
  return document[array][index];
}

std::vector<double> numbers(const json& array, std::size_t count) {
  if (!array.is_array() || array.size() != count ||
      !std::all_of(array.begin(), array.end(), [](const json& v) { return v.is_number(); })) {
    throw MeshFileError("a node's transformation is not " + std::to_string(count) + " numbers");
  }
  return array.get<std::vector<double>>();
}

Affine node_map(const json& node) {
  Affine map;
  if (node.contains("matrix")) {
    const std::vector<double> m = numbers(node["matrix"], 16);  // Column-major.
    for (std::size_t column = 0; column < 3; ++column) {
      map.columns[column] = {m[4 * column], m[4 * column + 1], m[4 * column + 2]};
    }
    map.translation = {m[12], m[13], m[14]};
    return map;
  }
  if (node.contains("rotation")) {
    const std::vector<double> q = numbers(node["rotation"], 4);
    const double x = q[0];
    const double y = q[1];
    const double z = q[2];
    const double w = q[3];
    map.columns = {Vec3{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                   Vec3{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                   Vec3{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
  }
  if (node.contains("scale")) {
    const std::vector<double> factors = numbers(node["scale"], 3);
    for (std::size_t i = 0; i < 3; ++i) map.columns[i] = scaled(map.columns[i], factors[i]);
  }
  if (node.contains("translation")) {
    const std::vector<double> by = numbers(node["translation"], 3);
    map.translation = {by[0], by[1], by[2]};
  }
  return map;
}

class GlbReader {
 public:
  GlbReader(const json& document, std::string_view binary,
            std::vector<std::size_t>* first_triangles)
      : document_(document), binary_(binary), first_triangles_(first_triangles) {}

  TriangleMesh read() {
    if (document_.contains("extensionsRequired")) {
      for (const json& extension : document_["extensionsRequired"]) {
        const auto name = extension.get<std::string>();
        if (std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) ==
            kKnownExtensions.end()) {
          throw MeshFileError("it needs the extension '" + name.substr(0, 60) +
                              "', which is not supported");
        }
      }
    }
    if (!document_.contains("scenes")) throw MeshFileError("it has no scene");
    const json& scene = element(document_, "scenes", whole_or(document_, "scene", 0));
    if (scene.contains("nodes")) {
      // Turns glTF's y-up to our z-up.
      const Affine turn = {.columns = {Vec3{1, 0, 0}, Vec3{0, 0, 1}, Vec3{0, -1, 0}}};
      for (const json& node : scene["nodes"]) add_node(whole(node), turn, 0);
    }
    for (const auto& [parts, map] : placed_) {
      if (first_triangles_ != nullptr) first_triangles_->push_back(mesh_.triangles.size());
      for (const json* primitive : parts->primitives) add_primitive(*primitive, map);
    }
    return std::move(mesh_);
  }

 private:
  void add_node(std::size_t number, const Affine& parent, int depth) {
    constexpr int kMaxDepth = 64;
    constexpr std::size_t kMaxNodes = 1'000'000;
    if (depth > kMaxDepth || ++nodes_ > kMaxNodes) {
      throw MeshFileError("its nodes form a cycle");
    }
    const json& node = element(document_, "nodes", number);
    const Affine map = composed(parent, node_map(node));
    if (node.contains("mesh")) {
      // These place a mesh elsewhere, even if the file does not require that readers know them.
      const bool has_instances =
          node.contains("extensions") && node["extensions"].contains("EXT_mesh_gpu_instancing");
      if (node.contains("skin") || has_instances) {
        throw MeshFileError(has_instances ? "a node has instances (EXT_mesh_gpu_instancing), which "
                                            "are not supported"
                                          : "a mesh has a skin, which is not supported");
      }
      const json& mesh = element(document_, "meshes", whole(node["mesh"]));
      const MeshParts& parts = parts_of(mesh);
      announced_.add(parts.count);
      placed_.emplace_back(&parts, map);
    }
    if (!node.contains("children")) return;
    for (const json& child : node["children"]) add_node(whole(child), map, depth + 1);
  }

  // The primitives of a mesh that have triangles or vertices, and what they announce.
  struct MeshParts {
    std::vector<const json*> primitives;
    InstanceCount count;
  };

  // A few bytes can instance the same mesh of many primitives a million times: each mesh is looked
  // through once, and all instances are counted before one is read.
  const MeshParts& parts_of(const json& mesh) {
    const auto [found, is_new] = parts_.try_emplace(&mesh);
    if (!is_new) return found->second;
    if (!mesh.contains("primitives")) throw MeshFileError("a mesh has no primitives");
    const auto size_of = [&](const json& accessor) {
      return whole_or(element(document_, "accessors", whole(accessor)), "count", 0);
    };
    for (const json& primitive : mesh["primitives"]) {
      if (!has_triangles(primitive)) continue;
      if (primitive.contains("targets")) {
        throw MeshFileError("a mesh has morph targets, which are not supported");
      }
      const std::size_t vertices = size_of(primitive["attributes"]["POSITION"]);
      const std::size_t corners =
          primitive.contains("indices") ? size_of(primitive["indices"]) : vertices;
      if (vertices == 0 && corners < 3 && draco_of(primitive) == nullptr) continue;
      found->second.count.add(vertices, corners / 3);
      found->second.primitives.push_back(&primitive);
    }
    return found->second;
  }

  // False for points and lines.
  static bool has_triangles(const json& primitive) {
    const std::size_t mode = whole_or(primitive, "mode", 4);
    if (mode > 4) throw MeshFileError("its triangles are strips or fans, which are not supported");
    if (mode < 4) return false;
    if (!primitive.contains("attributes") || !primitive["attributes"].contains("POSITION")) {
      throw MeshFileError("a primitive has no positions");
    }
    return true;
  }

  // Returns the extension for triangles that are compressed with Draco, or null.
  static const json* draco_of(const json& primitive) {
    if (!primitive.contains("extensions")) return nullptr;
    const auto found = primitive["extensions"].find(kDracoExtension);
    return found == primitive["extensions"].end() ? nullptr : &*found;
  }

  void add_primitive(const json& primitive, const Affine& map) {
    TriangleMesh part;
    if (const json* found = draco_of(primitive)) {
      const json& draco = *found;
      constexpr int kMaxDracoMeshes = 10'000;
      if (++draco_meshes_ > kMaxDracoMeshes) {
        throw MeshFileError("it has more than 10000 meshes compressed with Draco");
      }
      if (!draco.contains("bufferView") || !draco.contains("attributes") ||
          !draco["attributes"].contains("POSITION")) {
        throw MeshFileError("its Draco extension has no positions");
      }
      part = decoded_draco(view(whole(draco["bufferView"])).first,
                           static_cast<std::uint32_t>(whole(draco["attributes"]["POSITION"])));
    } else {
      part = plain_part(primitive);
    }
    read_.add(part.vertices.size(), part.triangles.size());
    append(mesh_, part, map);
  }

  TriangleMesh plain_part(const json& primitive) {
    TriangleMesh part;
    const json& positions =
        element(document_, "accessors", whole(primitive["attributes"]["POSITION"]));
    visit(positions, 3, [&](const std::array<double, 3>& v) { part.vertices.push_back(v); });
    std::vector<std::uint32_t> corners;
    if (primitive.contains("indices")) {
      visit(element(document_, "accessors", whole(primitive["indices"])), 1,
            [&](const std::array<double, 3>& v) {
              if (!(v[0] >= 0 && v[0] < static_cast<double>(part.vertices.size()))) {
                throw MeshFileError("a triangle refers to a missing vertex");
              }
              corners.push_back(static_cast<std::uint32_t>(v[0]));
            });
    } else {
      for (std::uint32_t i = 0; i < part.vertices.size(); ++i) corners.push_back(i);
    }
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      part.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    }
    return part;
  }

  // Returns the bytes of a view, and its stride or 0.
  std::pair<std::string_view, std::size_t> view(std::size_t number) {
    const json& description = element(document_, "bufferViews", number);
    if (description.contains("extensions") &&
        description["extensions"].contains(kMeshoptExtension)) {
      const std::string& bytes = unpacked(number, description["extensions"][kMeshoptExtension]);
      return {bytes, whole_or(description, "byteStride", 0)};
    }
    return {plain_view(description), whole_or(description, "byteStride", 0)};
  }

  std::string_view plain_view(const json& description) {
    if (whole_or(description, "buffer", 0) != 0 ||
        element(document_, "buffers", 0).contains("uri")) {
      throw MeshFileError("its arrays are in another file, which is not supported");
    }
    const std::size_t offset = whole_or(description, "byteOffset", 0);
    const std::size_t length = whole_or(description, "byteLength", 0);
    if (offset > binary_.size() || length > binary_.size() - offset) {
      throw MeshFileError("an array extends beyond the end of the file", kGetCompleteCopy);
    }
    return binary_.substr(offset, length);
  }

  // Returns the decoded bytes of a view with EXT_meshopt_compression. Filters are for normals and
  // floats; positions that have one are refused.
  const std::string& unpacked(std::size_t number, const json& packed) {
    const auto known = unpacked_.find(number);
    if (known != unpacked_.end()) return known->second;
    const std::string_view bytes = plain_view(packed);
    const std::size_t count = whole_or(packed, "count", 0);
    const std::size_t stride = whole_or(packed, "byteStride", 0);
    const std::string mode = packed.value("mode", "");
    const bool has_triangles = mode == "TRIANGLES";
    if (!has_triangles && mode != "ATTRIBUTES") {
      throw MeshFileError("its meshopt data have the mode '" + mode.substr(0, 20) +
                          "', which is not supported");
    }
    if (packed.value("filter", "NONE") != "NONE") {
      throw MeshFileError("its positions have a filter of meshopt, which is not supported");
    }
    // The codec takes at least two bits for sixteen equal bytes of elements, and a byte for a
    // triangle.
    constexpr std::size_t kMostOfAByte = 64;
    const bool is_valid =
        has_triangles ? (stride == 2 || stride == 4) && count % 3 == 0 && count / 3 <= bytes.size()
                      : stride > 0 && stride <= 256 && stride % 4 == 0 &&
                            count / kMostOfAByte * stride <= bytes.size();
    // Views may share their bytes.
    constexpr std::size_t kMaxUnpacked = std::size_t{1} << 33;
    if (is_valid && (unpacked_bytes_ += count * stride) > kMaxUnpacked) {
      throw MeshFileError("its meshopt data unpack to more than 8 GiB");
    }
    std::string decoded(is_valid ? count * stride : 0, '\0');
    const auto* const source = reinterpret_cast<const unsigned char*>(bytes.data());
    if (!is_valid ||
        (has_triangles
             ? meshopt_decodeIndexBuffer(decoded.data(), count, stride, source, bytes.size())
             : meshopt_decodeVertexBuffer(decoded.data(), count, stride, source, bytes.size())) !=
            0) {
      throw MeshFileError("its meshopt data are damaged");
    }
    return unpacked_.emplace(number, std::move(decoded)).first->second;
  }

  // Calls `take` for each element of an array of scalars or 3-vectors.
  template <typename Take>
  void visit(const json& accessor, std::size_t components, const Take& take) {
    if (accessor.contains("sparse") || !accessor.contains("bufferView")) {
      throw MeshFileError("it has a sparse array, which is not supported");
    }
    const std::string type = accessor.value("type", "");
    if (type != (components == 1 ? "SCALAR" : "VEC3")) {
      throw MeshFileError("an array has the wrong type " + type.substr(0, 20));
    }
    const std::size_t kind = whole_or(accessor, "componentType", 0);
    const bool is_known = kind >= 5120 && kind < 5120 + kComponentTypes.size();
    const auto number_type = is_known ? kComponentTypes[kind - 5120] : std::nullopt;
    if (!number_type)
      throw MeshFileError("an array has the unsupported component type " + std::to_string(kind));
    const auto [bytes, given_stride] = view(whole(accessor["bufferView"]));
    const std::size_t size = components * bytes_of(*number_type);
    const std::size_t stride = given_stride != 0 ? given_stride : size;
    const std::size_t offset = whole_or(accessor, "byteOffset", 0);
    const std::size_t count = whole_or(accessor, "count", 0);
    if (count == 0) return;
    if (stride < size || offset > bytes.size() || bytes.size() - offset < size ||
        (bytes.size() - offset - size) / stride < count - 1) {
      throw MeshFileError("an array extends beyond the end of the file", kGetCompleteCopy);
    }
    const bool is_normalized = accessor.value("normalized", false);
    for (std::size_t i = 0; i < count; ++i) {
      MeshBytes one(bytes.substr(offset + i * stride, size));
      std::array<double, 3> values{};
      for (std::size_t c = 0; c < components; ++c)
        values[c] = number(one, *number_type, is_normalized);
      take(values);
    }
  }

  static double number(MeshBytes& bytes, StoredType type, bool is_normalized) {
    return with_number_type(type, [&]<typename Number>() {
      const auto value = static_cast<double>(bytes.take_number<Number>());
      if (sizeof(Number) > 2 || !is_normalized) return value;
      return std::max(value / static_cast<double>(std::numeric_limits<Number>::max()), -1.0);
    });
  }

  const json& document_;
  std::string_view binary_;
  std::vector<std::size_t>* first_triangles_;
  TriangleMesh mesh_;
  std::map<const json*, MeshParts> parts_;                   // Of each mesh.
  std::vector<std::pair<const MeshParts*, Affine>> placed_;  // In the order of their nodes.
  InstanceCount announced_;
  InstanceCount read_;  // Draco data may hold more than announced.
  std::size_t nodes_ = 0;
  int draco_meshes_ = 0;
  std::map<std::size_t, std::string> unpacked_;  // By view, with EXT_meshopt_compression.
  std::size_t unpacked_bytes_ = 0;
};

}  // namespace

TriangleMesh read_glb(std::string_view file, std::vector<std::size_t>* first_triangles) {
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  MeshBytes bytes(file);
  bytes.take(4);
  if (bytes.take_number<std::uint32_t>() != 2) throw MeshFileError("it is not a glTF 2 file");
  bytes.take(4);  // Length of the file.
  const auto length = bytes.take_number<std::uint32_t>();
  if (bytes.take_number<std::uint32_t>() != kJsonChunk)
    throw MeshFileError("its first chunk is not JSON");
  const std::string_view text = bytes.take(length);
  std::string_view binary;
  if (bytes.size() >= 8) {
    const auto size = bytes.take_number<std::uint32_t>();
    bytes.take(4);  // Type of the binary chunk.
    binary = bytes.take(size);
  }
  const json document = parse_json(text);
  if (document.is_discarded()) throw MeshFileError("its JSON is damaged");
  try {
    return GlbReader(document, binary, first_triangles).read();
  } catch (const json::exception&) {
    throw MeshFileError("its JSON is not glTF");
  }
}

TriangleMesh read_draco(std::string_view file) { return decoded_draco(file, std::nullopt); }

}  // namespace multitetra

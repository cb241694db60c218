#include "common/wire/tile.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include <draco/attributes/attribute_octahedron_transform.h>
#include <draco/compression/attributes/normal_compression_utils.h>
#include <draco/compression/encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/mesh/mesh.h>

#include "common/wire/detail/file_positions.hpp"
#include "common/wire/detail/tile_payload.hpp"
#include "common/wire/draco_primitive.hpp"

namespace multitetra {
namespace {

// Adds an attribute with one value per point.
template <typename Value>
void add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type kind, draco::DataType type,
                   std::span<const Value> values) {
  static_assert(sizeof(Value) == 12, "Three coordinates of 4 bytes, without padding.");
  draco::GeometryAttribute attribute;
  attribute.Init(kind, nullptr, 3, type, false, sizeof(Value), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  mesh.attribute(id)->buffer()->Update(values.data(),
                                       static_cast<std::int64_t>(values.size_bytes()));
}

// Returns a Draco mesh whose points are numbered as `positions` and, unless empty, `normals`.
template <typename Position>
std::unique_ptr<draco::Mesh> draco_mesh(const std::vector<Position>& positions,
                                        draco::DataType type,
                                        const std::vector<TriangleIndices>& triangles,
                                        std::span<const UnitVector> normals) {
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(static_cast<std::uint32_t>(positions.size()));
  add_attribute(*mesh, draco::GeometryAttribute::POSITION, type, std::span(positions));
  if (!normals.empty()) {
    add_attribute(*mesh, draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, normals);
  }
  mesh->SetNumFaces(triangles.size());
  for (std::uint32_t face = 0; face < triangles.size(); ++face) {
    const TriangleIndices& t = triangles[face];
    mesh->SetFace(draco::FaceIndex(face),
                  {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
  return mesh;
}

// With fewer triangles the valence traversal costs more than it saves.
constexpr std::size_t kMinValenceTriangles = 1000;

// The valence traversal makes tiles 10 % smaller than the standard one and encoding 15 % slower.
// Draco itself uses it only at speeds below 5.
draco::Encoder edgebreaker(std::size_t triangles, int speed) {
  draco::Encoder encoder;
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.options().SetGlobalInt("edgebreaker_method",
                                 triangles < kMinValenceTriangles
                                     ? draco::MESH_EDGEBREAKER_STANDARD_ENCODING
                                     : draco::MESH_EDGEBREAKER_VALENCE_ENCODING);
  return encoder;
}

// Traverses normals together with positions: each vertex has one normal. With 8 bits on a noisy
// head, differences to the previous normal take 0.5 to 0.6 bytes per triangle; Draco's geometric
// prediction takes 0.8 and several times as long, as triangles predict noise poorly.
void add_normals(draco::Encoder& encoder, int bits) {
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, bits);
  encoder.SetAttributePredictionScheme(draco::GeometryAttribute::NORMAL,
                                       draco::PREDICTION_DIFFERENCE);
  encoder.options().SetGlobalBool("split_mesh_on_seams", true);
}

std::string encoded(draco::Encoder& encoder, const draco::Mesh& mesh) {
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeMeshToBuffer(mesh, &buffer);
  if (!status.ok()) {
    throw std::runtime_error("Draco cannot encode a mesh of " + std::to_string(mesh.num_faces()) +
                             " triangles: " + status.error_msg_string());
  }
  return {buffer.data(), buffer.size()};
}

[[maybe_unused]] bool is_encodable(const LatticeMesh& mesh) {
  const auto proper = [&mesh](const TriangleIndices& t) {
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0] &&
           *std::max_element(t.begin(), t.end()) < mesh.vertices.size();
  };
  return !mesh.triangles.empty() && mesh.triangles.size() <= kMaxTileTriangles &&
         std::all_of(mesh.triangles.begin(), mesh.triangles.end(), proper) &&
         std::all_of(mesh.vertices.begin(), mesh.vertices.end(), is_on_lattice);
}

bool is_normal_bits(int bits) { return bits >= kMinNormalBits && bits <= kMaxNormalBits; }

[[maybe_unused]] bool is_encodable(const TileNormals& normals, std::size_t vertices) {
  if (normals.bits == 0) return normals.directions.empty();
  return is_normal_bits(normals.bits) && normals.directions.size() == vertices &&
         std::all_of(normals.directions.begin(), normals.directions.end(), is_unit);
}

std::string prefix(const TileSummary& tile) { return "Tile at " + to_string(tile.cube) + ": "; }

tl::unexpected<Error> damaged(const TileSummary& tile, const std::string& what) {
  return fail(ErrorCode::kDamagedData, prefix(tile) + what);
}

tl::unexpected<Error> miscounted(const TileSummary& tile, const char* what, std::uint64_t found,
                                 std::uint64_t promised) {
  return damaged(tile, "the payload has " + std::to_string(found) + " " + what +
                           "; the manifest lists " + std::to_string(promised) + ".");
}

// Draco's decoder, stopped before it allocates memory for attributes we never write: each of them
// would cost memory for all points, but hardly a byte of payload.
class PromisedAttributesDecoder : public draco::MeshEdgebreakerDecoder {
 public:
  explicit PromisedAttributesDecoder(std::string_view attributes) : attributes_(attributes) {}

 protected:
  bool CreateAttributesDecoder(std::int32_t id) override {
    if (id != 0 || !draco::MeshEdgebreakerDecoder::CreateAttributesDecoder(id)) return false;
    const auto remaining = static_cast<std::size_t>(buffer()->remaining_size());
    return std::string_view(buffer()->data_head(), remaining).starts_with(attributes_);
  }

 private:
  std::string_view attributes_;
};

// Decodes to Draco's mesh, with normals as octahedral integers; null if Draco fails.
std::unique_ptr<draco::Mesh> draco_decoded(std::string_view payload, bool has_normals) {
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(payload.data(), payload.size());
    auto mesh = std::make_unique<draco::Mesh>();
    PromisedAttributesDecoder decoder(has_normals ? kTileAttributesWithNormals : kTileAttribute);
    draco::DecoderOptions options;
    options.SetAttributeBool(draco::GeometryAttribute::NORMAL, "skip_attribute_transform", true);
    return decoder.Decode(options, &buffer, mesh.get()).ok() ? std::move(mesh) : nullptr;
  } catch (const std::bad_alloc&) {
    throw;  // Really out of memory, as the payload's claims were compared with the manifest.
  } catch (const std::exception&) {
    return nullptr;
  }
}

// Returns Draco's points and triangles, in which a vertex may occur several times. nullopt if the
// mesh contradicts itself.
std::optional<LatticeMesh> unwelded(const draco::Mesh& mesh, int resolution) {
  const draco::PointAttribute* position =
      mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (position == nullptr || position->data_type() != draco::DT_INT32 ||
      position->num_components() != 3) {
    return std::nullopt;
  }
  LatticeMesh result{.resolution = resolution, .vertices = {}, .triangles = {}};
  result.vertices.reserve(mesh.num_points());
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex at = position->mapped_index(point);
    if (at.value() >= position->size()) return std::nullopt;
    std::array<std::int32_t, 3> value{};
    position->GetValue(at, value.data());
    result.vertices.push_back({value[0], value[1], value[2]});
  }
  result.triangles.reserve(mesh.num_faces());
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
    const draco::Mesh::Face& corners = mesh.face(face);
    TriangleIndices triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (corners[i].value() >= mesh.num_points()) return std::nullopt;
      triangle[i] = corners[i].value();
    }
    result.triangles.push_back(triangle);
  }
  return result;
}

// Returns one normal per point; nullopt if the bits differ or a coordinate is out of range.
std::optional<std::vector<UnitVector>> unwelded_normals(const draco::Mesh& mesh, int bits) {
  const draco::PointAttribute* normal = mesh.GetNamedAttribute(draco::GeometryAttribute::NORMAL);
  draco::AttributeOctahedronTransform transform;
  draco::OctahedronToolBox octahedron;
  if (normal == nullptr || normal->num_components() != 2 ||
      draco::DataTypeLength(normal->data_type()) != sizeof(std::int32_t) ||
      normal->GetAttributeTransformData() == nullptr || !transform.InitFromAttribute(*normal) ||
      transform.quantization_bits() != bits || !octahedron.SetQuantizationBits(bits)) {
    return std::nullopt;
  }
  const auto is_coordinate = [&](std::int32_t v) { return v >= 0 && v <= octahedron.max_value(); };
  std::vector<UnitVector> normals;
  normals.reserve(mesh.num_points());
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex at = normal->mapped_index(point);
    if (at.value() >= normal->size()) return std::nullopt;
    std::array<std::int32_t, 2> value{};
    normal->GetValue(at, value.data());
    if (!is_coordinate(value[0]) || !is_coordinate(value[1])) return std::nullopt;
    UnitVector direction{};
    octahedron.QuantizedOctahedralCoordsToUnitVector(value[0], value[1], direction.data());
    if (!is_unit(direction)) return std::nullopt;
    normals.push_back(direction);
  }
  return normals;
}

// Returns whether copies of split vertices have equal normals. Welding keeps triangles in order.
bool has_one_normal_a_vertex(const LatticeMesh& welded, const LatticeMesh& split) {
  for (std::size_t i = 0; i < split.triangles.size(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (welded.normals[welded.triangles[i][corner]] !=
          split.normals[split.triangles[i][corner]]) {
        return false;
      }
    }
  }
  return true;
}

bool has_degenerate_triangle(const LatticeMesh& mesh) {
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [](const TriangleIndices& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
}

std::size_t used_vertices(const LatticeMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size());
  for (const TriangleIndices& t : mesh.triangles) {
    for (const std::uint32_t corner : t) used[corner] = true;
  }
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
}

}  // namespace

EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube, int speed,
                        const TileNormals& normals) {
  return encode_tile(mesh, cube, digest(mesh), speed, normals);
}

EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube,
                        const ContentDigest& content, int speed, const TileNormals& normals) {
  assert(speed >= 0 && speed < 10);
  assert(is_encodable(mesh));
  assert(is_encodable(normals, mesh.vertices.size()));
  draco::Encoder encoder = edgebreaker(mesh.triangles.size(), speed);
  if (normals.bits != 0) add_normals(encoder, normals.bits);
  auto payload = std::make_shared<const std::string>(encoded(
      encoder, *draco_mesh(mesh.vertices, draco::DT_INT32, mesh.triangles, normals.directions)));
  return {.summary = {.cube = cube,
                      .digest = content,
                      .triangles = static_cast<std::uint32_t>(mesh.triangles.size()),
                      .vertices = static_cast<std::uint32_t>(mesh.vertices.size()),
                      .bytes = static_cast<std::uint32_t>(payload->size())},
          .payload = std::move(payload)};
}

void round_normals(std::vector<UnitVector>& normals, int bits) {
  if (normals.empty()) return;
  draco::OctahedronToolBox octahedron;
  [[maybe_unused]] const bool is_possible = octahedron.SetQuantizationBits(bits);
  assert(is_possible);
  for (UnitVector& normal : normals) {
    std::int32_t s = 0;
    std::int32_t t = 0;
    octahedron.FloatVectorToQuantizedOctahedralCoords(normal.data(), &s, &t);
    octahedron.QuantizedOctahedralCoordsToUnitVector(s, t, normal.data());
  }
}

Result<LatticeMesh> decode_tile(std::string_view payload, const TileSummary& promised,
                                int lattice_resolution, int normal_bits) {
  assert(normal_bits == 0 || is_normal_bits(normal_bits));
  if (payload.size() != promised.bytes) {
    return miscounted(promised, "bytes", payload.size(), promised.bytes);
  }
  if (promised.triangles > kMaxTileTriangles) {
    return damaged(promised, "the manifest lists " + std::to_string(promised.triangles) +
                                 " triangles; a tile has at most " +
                                 std::to_string(kMaxTileTriangles) + ".");
  }
  const Result<TilePayloadClaims> claims = read_claims(payload);
  if (!claims) return damaged(promised, claims.error().text);
  if (claims->triangles != promised.triangles) {
    return miscounted(promised, "triangles", claims->triangles, promised.triangles);
  }
  if (claims->vertices < promised.vertices) {
    return miscounted(promised, "vertices", claims->vertices, promised.vertices);
  }
  const std::unique_ptr<draco::Mesh> decoded = draco_decoded(payload, normal_bits != 0);
  if (!decoded) return damaged(promised, "Draco cannot decode the payload.");
  std::optional<LatticeMesh> split = unwelded(*decoded, lattice_resolution);
  if (!split) return damaged(promised, "the decoded mesh is inconsistent.");
  if (normal_bits != 0) {
    std::optional<std::vector<UnitVector>> normals = unwelded_normals(*decoded, normal_bits);
    if (!normals) {
      return damaged(promised, "the normals are not unit vectors in octahedral coordinates of " +
                                   std::to_string(normal_bits) + " bits.");
    }
    split->normals = *std::move(normals);
  }
  for (const LatticePoint& p : split->vertices) {
    if (is_on_lattice(p) && promised.cube.contains(p, lattice_resolution)) continue;
    return damaged(promised, "a vertex at lattice (" + std::to_string(p.x) + ", " +
                                 std::to_string(p.y) + ", " + std::to_string(p.z) +
                                 ") lies outside the tile's cube.");
  }
  LatticeMesh mesh = weld(std::span(&*split, 1), lattice_resolution);
  if (mesh.triangles.size() != promised.triangles) {
    return miscounted(promised, "triangles", mesh.triangles.size(), promised.triangles);
  }
  if (mesh.vertices.size() != promised.vertices || used_vertices(mesh) != promised.vertices) {
    return miscounted(promised, "vertices", used_vertices(mesh), promised.vertices);
  }
  if (normal_bits != 0 && !has_one_normal_a_vertex(mesh, *split)) {
    return damaged(promised, "a vertex has several normals.");
  }
  if (has_degenerate_triangle(mesh)) {
    return damaged(promised, "two corners of a triangle are the same vertex.");
  }
  if (const ContentDigest found = digest(mesh); found != promised.digest) {
    return damaged(promised, "the triangles have the digest " + found.hex() +
                                 "; the manifest lists " + promised.digest.hex() + ".");
  }
  return mesh;
}

DracoPrimitive encode_draco_primitive(const LatticeMesh& mesh, const OctreeCube& cube) {
  assert(is_encodable(mesh));
  std::vector<std::array<float, 3>> positions;
  positions.reserve(mesh.vertices.size());
  for (const LatticePoint& p : mesh.vertices) {  // Coordinates below 2^24 are exact.
    positions.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  draco::Encoder encoder = edgebreaker(mesh.triangles.size(), kSimplifiedEncodingSpeed);
  // Origin and range are integers, which Draco's six decimals hold exactly, and the step is one.
  const int bits = cube.exponent + mesh.resolution + 1;
  const auto side = static_cast<float>(std::int64_t{cube.side()} << mesh.resolution);
  const std::array<float, 3> origin = {static_cast<float>(cube.x) * side,
                                       static_cast<float>(cube.y) * side,
                                       static_cast<float>(cube.z) * side};
  encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, bits, 3,
                                           origin.data(), 2 * side - 1);
  if (!mesh.normals.empty()) add_normals(encoder, kMaxNormalBits);
  encoder.SetTrackEncodedProperties(true);
  DracoPrimitive primitive;
  primitive.bytes =
      encoded(encoder, *draco_mesh(positions, draco::DT_FLOAT32, mesh.triangles, mesh.normals));
  primitive.points = static_cast<std::uint32_t>(encoder.num_encoded_points());
  primitive.triangles = static_cast<std::uint32_t>(encoder.num_encoded_faces());
  return primitive;
}

std::string encode_draco_integers(const std::vector<std::array<std::int32_t, 3>>& positions,
                                  const std::vector<TriangleIndices>& triangles) {
  assert(!triangles.empty() && triangles.size() <= kMaxTileTriangles);
  draco::Encoder encoder = edgebreaker(triangles.size(), kSimplifiedEncodingSpeed);
  return encoded(encoder, *draco_mesh(positions, draco::DT_INT32, triangles, {}));
}

std::string encode_draco_file(const PositionedMesh& mesh, int position_bits) {
  assert(position_bits >= 1 && position_bits <= 30);
  draco::Encoder encoder = edgebreaker(mesh.triangles.size(), kDefaultEncodingSpeed);
  // A single mesh needs no lattice in common with others, and Draco stores explicit ranges with
  // only six decimals.
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  if (!mesh.normals.empty()) add_normals(encoder, kMaxNormalBits);
  return encoded(
      encoder, *draco_mesh(float_positions(mesh), draco::DT_FLOAT32, mesh.triangles, mesh.normals));
}

}  // namespace multitetra

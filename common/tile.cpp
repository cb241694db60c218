#include "common/tile.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>

#include <draco/compression/encode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/mesh/mesh.h>

#include "common/tile_payload.hpp"

namespace multitetra {
namespace {

// A Draco mesh with one attribute, its points numbered as `values`.
template <typename Value>
std::unique_ptr<draco::Mesh> draco_mesh(const std::vector<Value>& values, draco::DataType type,
                                        const std::vector<TriangleIndices>& triangles) {
  static_assert(sizeof(Value) == 12, "Three coordinates of 4 bytes, without padding.");
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(static_cast<std::uint32_t>(values.size()));
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, type, false, sizeof(Value), 0);
  const int id = mesh->AddAttribute(position, true, static_cast<std::uint32_t>(values.size()));
  mesh->attribute(id)->buffer()->Update(values.data(),
                                        static_cast<std::int64_t>(values.size() * sizeof(Value)));
  mesh->SetNumFaces(triangles.size());
  for (std::uint32_t face = 0; face < triangles.size(); ++face) {
    const TriangleIndices& t = triangles[face];
    mesh->SetFace(draco::FaceIndex(face),
                  {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
  return mesh;
}

// Below this number of triangles the valence traversal costs more than it saves.
constexpr std::size_t kMinValenceTriangles = 1000;

// The valence traversal makes tiles 10 % smaller than the standard one and encoding 15 % slower.
// Draco itself would take it only at speeds below 5.
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

std::string prefix(const TileSummary& tile) { return "Tile at " + to_string(tile.cube) + ": "; }

tl::unexpected<Error> damaged(const TileSummary& tile, const std::string& what) {
  return fail(ErrorCode::kDamagedData, prefix(tile) + what);
}

tl::unexpected<Error> miscounted(const TileSummary& tile, const char* what, std::uint64_t found,
                                 std::uint64_t promised) {
  return damaged(tile, "the payload has " + std::to_string(found) + " " + what +
                           "; the manifest promises " + std::to_string(promised) + ".");
}

// Draco's decoder, stopped before it allocates for attributes that we never write: each further one
// would cost memory for all points and hardly a byte.
class OneAttributeDecoder : public draco::MeshEdgebreakerDecoder {
 protected:
  bool CreateAttributesDecoder(std::int32_t id) override {
    if (id != 0 || !draco::MeshEdgebreakerDecoder::CreateAttributesDecoder(id)) return false;
    const auto remaining = static_cast<std::size_t>(buffer()->remaining_size());
    return std::string_view(buffer()->data_head(), remaining).starts_with(kTileAttribute);
  }
};

// The bytes as Draco's mesh; none when Draco refuses them.
std::unique_ptr<draco::Mesh> draco_decoded(std::string_view payload) {
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(payload.data(), payload.size());
    auto mesh = std::make_unique<draco::Mesh>();
    OneAttributeDecoder decoder;
    return decoder.Decode(draco::DecoderOptions(), &buffer, mesh.get()).ok() ? std::move(mesh)
                                                                             : nullptr;
  } catch (const std::exception&) {
    return nullptr;
  }
}

// Points and triangles as Draco has them: vertices may occur several times. None when the mesh
// contradicts itself.
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

EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube, int speed) {
  return encode_tile(mesh, cube, digest(mesh), speed);
}

EncodedTile encode_tile(const LatticeMesh& mesh, const OctreeCube& cube,
                        const ContentDigest& content, int speed) {
  assert(speed >= 0 && speed < 10);
  assert(is_encodable(mesh));
  draco::Encoder encoder = edgebreaker(mesh.triangles.size(), speed);
  auto payload = std::make_shared<const std::string>(
      encoded(encoder, *draco_mesh(mesh.vertices, draco::DT_INT32, mesh.triangles)));
  return {.summary = {.cube = cube,
                      .digest = content,
                      .triangles = static_cast<std::uint32_t>(mesh.triangles.size()),
                      .vertices = static_cast<std::uint32_t>(mesh.vertices.size()),
                      .bytes = static_cast<std::uint32_t>(payload->size())},
          .payload = std::move(payload)};
}

Result<LatticeMesh> decode_tile(std::string_view payload, const TileSummary& promised,
                                int lattice_resolution) {
  if (payload.size() != promised.bytes) {
    return miscounted(promised, "bytes", payload.size(), promised.bytes);
  }
  if (promised.triangles > kMaxTileTriangles) {
    return damaged(promised, "the manifest promises " + std::to_string(promised.triangles) +
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
  const std::unique_ptr<draco::Mesh> decoded = draco_decoded(payload);
  if (!decoded) return damaged(promised, "Draco cannot decode the payload.");
  const std::optional<LatticeMesh> split = unwelded(*decoded, lattice_resolution);
  if (!split) return damaged(promised, "the decoded mesh contradicts itself.");
  for (const LatticePoint& p : split->vertices) {
    if (is_on_lattice(p) && promised.cube.contains(p, lattice_resolution)) continue;
    return damaged(promised, "a vertex at lattice (" + std::to_string(p.x) + ", " +
                                 std::to_string(p.y) + ", " + std::to_string(p.z) +
                                 ") lies outside the tile's cube.");
  }
  const LatticeMesh* const pieces[] = {&*split};
  LatticeMesh mesh = weld(pieces, lattice_resolution);
  if (mesh.triangles.size() != promised.triangles) {
    return miscounted(promised, "triangles", mesh.triangles.size(), promised.triangles);
  }
  if (mesh.vertices.size() != promised.vertices || used_vertices(mesh) != promised.vertices) {
    return miscounted(promised, "vertices", used_vertices(mesh), promised.vertices);
  }
  if (has_degenerate_triangle(mesh)) {
    return damaged(promised, "two corners of a triangle are the same vertex.");
  }
  if (const ContentDigest found = digest(mesh); found != promised.digest) {
    return damaged(promised, "the triangles have the digest " + found.hex() +
                                 "; the manifest promises " + promised.digest.hex() + ".");
  }
  return mesh;
}

std::string encode_draco_file(const PositionedMesh& mesh, int position_bits) {
  assert(position_bits >= 1 && position_bits <= 30);
  draco::Encoder encoder = edgebreaker(mesh.triangles.size(), kDefaultEncodingSpeed);
  // One mesh alone needs no lattice in common with others, and Draco keeps explicit ranges with six
  // decimals only.
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, position_bits);
  return encoded(encoder, *draco_mesh(mesh.positions, draco::DT_FLOAT32, mesh.triangles));
}

}  // namespace multitetra

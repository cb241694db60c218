#include "common/wire/draco_mesh.hpp"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

namespace multitetra {

Result<DracoMesh> decode_draco_mesh(std::string_view bytes,
                                    std::optional<std::uint32_t> position_id) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) {
    return fail(ErrorCode::kDamagedData,
                "Draco cannot decode it (" + decoded.status().error_msg_string() + ")");
  }
  const draco::Mesh& mesh = *decoded.value();
  const draco::PointAttribute* const positions =
      position_id ? mesh.GetAttributeByUniqueId(*position_id)
                  : mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (positions == nullptr || positions->num_components() != 3) {
    return fail(ErrorCode::kDamagedData, "its Draco mesh has no positions");
  }
  DracoMesh result;
  result.positions.resize(mesh.num_points());
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    Vec3& place = result.positions[point.value()];
    if (!positions->ConvertValue<double>(positions->mapped_index(point), 3, place.data())) {
      return fail(ErrorCode::kDamagedData, "its Draco mesh has positions that are not numbers");
    }
  }
  result.triangles.reserve(mesh.num_faces());
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
    const draco::Mesh::Face& corners = mesh.face(face);
    for (const draco::PointIndex& corner : corners) {
      if (corner.value() >= mesh.num_points()) {
        return fail(ErrorCode::kDamagedData, "its Draco mesh is inconsistent");
      }
    }
    result.triangles.push_back({corners[0].value(), corners[1].value(), corners[2].value()});
  }
  return result;
}

}  // namespace multitetra

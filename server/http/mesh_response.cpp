#include "server/http/mesh_response.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/request_notices.hpp"
#include "server/http/step_mesh.hpp"

namespace multitetra {
namespace {

// Whoever holds the file holds its room.
struct FileInItsRoom {
  FileInItsRoom(const std::filesystem::path& folder, ByteReservations::Reservation room_of_it)
      : room(std::move(room_of_it)), file(folder) {}
  ByteReservations::Reservation room;
  ScratchFile file;
};

Result<MeshTopology> checked(const LatticeMesh& mesh, const OneShotSession::Step& step,
                             const DatasetInfo& info) {
  const IsosurfaceRequest& request = step.begin.request;
  const MeshTopology found =
      topology(mesh, data_border(info, request.lattice_resolution, request.topology_tolerance,
                                 step.begin.finest_spacing));
  if (!found.is_sound() || digest(mesh) != step.end.digest) {
    return fail(ErrorCode::kDamagedData,
                "The mesh has a crack or is not the one that was announced: this is the server's "
                "mistake.");
  }
  return found;
}

// Why a mesh may not be what its reader meant, a field each.
void add_notices(Answer& answer, const MeshTopology& mesh, const IsosurfaceRequest& request,
                 const DatasetInfo& info) {
  std::vector<std::string> notices = request_notices(request, info);
  if (mesh.triangles == 0) {
    const std::string empty = empty_surface_text(request, info);
    if (std::find(notices.begin(), notices.end(), empty) == notices.end()) notices.push_back(empty);
  }
  for (const std::string& notice : notices) add_field(answer, "Multitetra-Notice", notice);
}

std::string facts(const MeshTopology& mesh, const OneShotSession::Step& step,
                  const DatasetInfo& info) {
  Answer answer;
  add_notices(answer, mesh, step.begin.request, info);
  add_field(answer, "Multitetra-Triangles", std::to_string(mesh.triangles));
  add_field(answer, "Multitetra-Vertices", std::to_string(mesh.vertices));
  add_field(answer, "Multitetra-Euler-Characteristic", std::to_string(mesh.euler_characteristic));
  add_field(answer, "Multitetra-Components", std::to_string(mesh.components));
  add_field(answer, "Multitetra-Error-Bound", shortest_text(step.begin.error_bound_world));
  add_field(answer, "Multitetra-Content-Digest", step.end.digest.hex());
  return answer.fields;
}

}  // namespace

Result<StoredMesh> store_mesh(const OneShotSession::Step& step, const DatasetInfo& info,
                              const MeshForm& form, const MeshPlace& place,
                              const std::stop_token& stop) {
  auto mesh = welded_mesh(step, stop);
  if (!mesh) return tl::unexpected(mesh.error());
  const auto found = checked(*mesh, step, info);
  if (!found) return tl::unexpected(found.error());
  const std::string bytes = mesh_file(
      positioned(*mesh, form.is_in_world ? grid_to_world(info) : grid_to_index(info)), form.format);
  *mesh = {};
  auto room = place.room(bytes.size());
  if (!room) return tl::unexpected(room.error());
  const auto stored = std::make_shared<FileInItsRoom>(place.folder, *std::move(room));
  static_cast<void>(stored->file.put(std::as_bytes(std::span(bytes))));
  return StoredMesh{.file = SharedFile(stored, &stored->file),
                    .bytes = bytes.size(),
                    .fields = facts(*found, step, info)};
}

}  // namespace multitetra

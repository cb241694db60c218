#include "server/http/mesh_response.hpp"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/mesh/components.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/scene_file.hpp"
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

// What all surfaces of a file are together.
struct Totals {
  MeshTopology topology;
  double error_bound = 0;
  ContentDigest digest;
  std::size_t components_written = 0;

  void add(const MeshTopology& mesh, const OneShotSession::Step& step) {
    topology.triangles += mesh.triangles;
    topology.vertices += mesh.vertices;
    topology.euler_characteristic += mesh.euler_characteristic;
    topology.components += mesh.components;
    error_bound = std::max(error_bound, step.begin.error_bound_world);
    digest += step.end.digest;
  }
};

void add_facts(Answer& answer, const Totals& all) {
  const MeshTopology& mesh = all.topology;
  add_field(answer, "Multitetra-Triangles", std::to_string(mesh.triangles));
  add_field(answer, "Multitetra-Vertices", std::to_string(mesh.vertices));
  add_field(answer, "Multitetra-Euler-Characteristic", std::to_string(mesh.euler_characteristic));
  add_field(answer, "Multitetra-Components", std::to_string(mesh.components));
  add_field(answer, "Multitetra-Components-Written", std::to_string(all.components_written));
  add_field(answer, "Multitetra-Error-Bound", shortest_text(all.error_bound));
  add_field(answer, "Multitetra-Content-Digest", all.digest.hex());
}

PositionedMesh painted(const LatticeMesh& mesh, const StepBegin& step, const DatasetInfo& info,
                       const MeshForm& form) {
  PositionedMesh placed =
      positioned(mesh, form.is_in_world ? grid_to_world(info) : grid_to_index(info));
  if (step.scalars) {
    ColorScale scale = form.colors;
    scale.low = step.scalars->low;
    scale.high = step.scalars->high;
    placed.colors = colors_of(placed.scalars, scale);
  }
  return placed;
}

std::string file_of(const std::vector<PositionedMesh>& meshes,
                    const std::vector<OneShotSession::Step>& steps, MeshFormat format) {
  if (meshes.size() == 1) return mesh_file(meshes.front(), format);
  assert(format == MeshFormat::kGlb);
  std::vector<ScenePart> parts;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    parts.push_back(
        {.name = "isovalue " + shortest_text(steps[i].begin.request.isovalue), .mesh = &meshes[i]});
  }
  return scene_glb(parts);
}

}  // namespace

Result<StoredMesh> store_mesh(const std::vector<OneShotSession::Step>& steps,
                              const DatasetInfo& info, const MeshForm& form, const MeshPlace& place,
                              const std::stop_token& stop) {
  Answer told;
  Totals all;
  std::vector<PositionedMesh> meshes;
  for (const OneShotSession::Step& step : steps) {
    const auto mesh = welded_mesh(step, stop);
    if (!mesh) return tl::unexpected(mesh.error());
    const auto found = checked(*mesh, step, info);
    if (!found) return tl::unexpected(found.error());
    add_notices(told, *found, step.begin.request, info);
    all.add(*found, step);
    const MeshComponents components = components_of(*mesh);
    const std::size_t written = components.count_from(form.min_component);
    all.components_written += written;
    meshes.push_back(written == components.diagonals.size()
                         ? painted(*mesh, step.begin, info, form)
                         : painted(with_components(*mesh, components, form.min_component),
                                   step.begin, info, form));
  }
  add_facts(told, all);
  const std::string bytes = file_of(meshes, steps, form.format);
  meshes.clear();
  auto room = place.room(bytes.size());
  if (!room) return tl::unexpected(room.error());
  const auto stored = std::make_shared<FileInItsRoom>(place.folder, *std::move(room));
  static_cast<void>(stored->file.put(std::as_bytes(std::span(bytes))));
  return StoredMesh{.file = SharedFile(stored, &stored->file),
                    .bytes = bytes.size(),
                    .fields = std::move(told.fields)};
}

}  // namespace multitetra

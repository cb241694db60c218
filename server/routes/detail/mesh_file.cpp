#include "server/routes/detail/mesh_file.hpp"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/mesh/components.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/request/painted_mesh.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {
namespace {

struct ReservedFile {
  ReservedFile(const std::filesystem::path& folder, ByteReservations::Reservation reserved)
      : reservation(std::move(reserved)), file(folder) {}
  ByteReservations::Reservation reservation;
  ScratchFile file;
};

Result<MeshTopology> checked(const Surface& surface, const DatasetInfo& info) {
  const IsosurfaceRequest& request = surface.request;
  const MeshTopology found =
      topology(surface.mesh, data_border(info, request.lattice_resolution,
                                         request.topology_tolerance, surface.finest_spacing));
  if (found.is_sound()) return found;
  return fail(ErrorCode::kDamagedData, "Internal error: the mesh has a crack.");
}

// Adds a field for each reason why a mesh may differ from what the user expects.
void add_notices(HttpResponse& response, const MeshTopology& mesh, const IsosurfaceRequest& request,
                 const DatasetInfo& info) {
  std::vector<std::string> notices = request_notices(request, info);
  if (mesh.triangles == 0) {
    const std::string empty = empty_surface_text(request, info);
    if (std::find(notices.begin(), notices.end(), empty) == notices.end()) notices.push_back(empty);
  }
  for (const std::string& notice : notices) add_field(response, "Multitetra-Notice", notice);
}

// Requires that components are removed.
void add_removal_notices(HttpResponse& response, const LatticeMesh& mesh,
                         const MeshComponents& components, double shortest,
                         const DatasetInfo& info) {
  if (components.count_at_least(shortest) == 0) {
    add_field(
        response, "Multitetra-Notice",
        "The surface is empty: min_component removes all its components; the longest diagonal "
        "is " +
            rounded_text(components.diagonals[components.largest()]) + " samples.");
    return;
  }
  const FilledCavities filled = filled_cavities(mesh, components, shortest, grid_to_world(info));
  if (filled.count > 0) {
    add_field(response, "Multitetra-Notice", "min_component: " + filled_text(filled) + ".");
  }
}

// Totals over all surfaces of a file.
struct Totals {
  MeshTopology topology;
  double error_bound = 0;
  ContentDigest digest;
  std::size_t components_written = 0;

  void add(const MeshTopology& mesh, const Surface& surface) {
    topology.triangles += mesh.triangles;
    topology.vertices += mesh.vertices;
    topology.euler_characteristic += mesh.euler_characteristic;
    topology.components += mesh.components;
    error_bound = std::max(error_bound, surface.error_bound_world);
    digest += surface.digest;
  }
};

void add_facts(HttpResponse& response, const Totals& all) {
  const MeshTopology& mesh = all.topology;
  add_field(response, "Multitetra-Triangles", std::to_string(mesh.triangles));
  add_field(response, "Multitetra-Vertices", std::to_string(mesh.vertices));
  add_field(response, "Multitetra-Euler-Characteristic", std::to_string(mesh.euler_characteristic));
  add_field(response, "Multitetra-Components", std::to_string(mesh.components));
  add_field(response, "Multitetra-Components-Written", std::to_string(all.components_written));
  add_field(response, "Multitetra-Error-Bound", shortest_text(all.error_bound));
  add_field(response, "Multitetra-Content-Digest", all.digest.hex());
}

// What is known of it. A unit may have letters that no header field has.
void add_world(HttpResponse& response, const PhysicalMeaning& world) {
  if (!world.length_unit.empty()) {
    add_field(response, "Multitetra-Length-Unit", percent_encoded(world.length_unit));
  }
  if (world.space != WorldSpace::kUnnamed) {
    add_field(response, "Multitetra-Space", name(world.space));
  }
}

PositionedMesh painted(const LatticeMesh& mesh, const std::optional<ScalarRange>& scalars,
                       const DatasetInfo& info, const MeshFileOptions& form) {
  PositionedMesh placed =
      positioned(mesh, form.is_in_world ? grid_to_world(info) : grid_to_index(info));
  paint(placed, scalars, form.colors);
  return placed;
}

std::string file_of(const std::vector<PositionedMesh>& meshes, const std::vector<double>& isovalues,
                    MeshFormat format, const MeshFileFacts& facts) {
  if (meshes.size() == 1) return mesh_file(meshes.front(), format, facts);
  assert(format == MeshFormat::kGlb);
  std::vector<ScenePart> parts;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    parts.push_back({.name = {"isovalue " + shortest_text(isovalues[i]), facts.name.label},
                     .mesh = &meshes[i]});
  }
  return scene_glb(parts, facts.world, facts.codec);
}

}  // namespace

Result<StoredMesh> store_mesh(std::vector<Surface> surfaces, const DatasetInfo& info,
                              const MeshFileOptions& form, const MeshStorage& place,
                              const std::stop_token& stop) {
  HttpResponse header;
  Totals all;
  std::vector<PositionedMesh> meshes;
  std::vector<double> isovalues;
  int lattice = kDefaultLatticeResolution;
  double shortest = 0;
  double rounding = 0;
  for (Surface& surface : surfaces) {
    if (stop.stop_requested()) return fail(ErrorCode::kCancelled, "The client has disconnected.");
    const auto found = checked(surface, info);
    if (!found) return tl::unexpected(found.error());
    add_notices(header, *found, surface.request, info);
    all.add(*found, surface);
    for (const auto& text : missing_values_notice(surface.mesh.scalars, form.color_by)) {
      add_field(header, "Multitetra-Notice", text);
    }
    const MeshComponents components = components_of(surface.mesh);
    shortest = components.least(form.min_component);
    const std::size_t written = components.count_at_least(shortest);
    all.components_written += written;
    if (written != components.diagonals.size()) {
      add_removal_notices(header, surface.mesh, components, shortest, info);
      surface.mesh = with_components(surface.mesh, components, shortest);
    }
    surface.mesh = in_canonical_order(surface.mesh);
    meshes.push_back(painted(surface.mesh, surface.scalars, info, form));
    if (form.codec == MeshCodec::kMeshopt && form.is_in_world) {
      rounding = std::max(rounding, position_rounding(meshes.back()));
    }
    isovalues.push_back(surface.request.isovalue);
    lattice = surface.mesh.resolution;
    surface.mesh = {};
  }
  all.error_bound += rounding;
  add_facts(header, all);
  const PhysicalMeaning world = form.is_in_world ? info.meaning : PhysicalMeaning();
  add_world(header, world);
  std::string bytes;
  try {
    bytes = file_of(meshes, isovalues, form.format,
                    {.name = surface_name(info),
                     .lattice = lattice,
                     .min_component = shortest,
                     .world = world,
                     .codec = form.codec});
  } catch (const MeshCoordinatesError& error) {
    return fail(ErrorCode::kInvalidArgument, error.what());
  }
  meshes.clear();
  if (bytes.size() <= place.max_in_memory) {
    return StoredMesh{.body = body_of(std::make_shared<const std::string>(std::move(bytes))),
                      .fields = std::move(header.fields)};
  }
  auto reservation = place.reservation(bytes.size());
  if (!reservation) return tl::unexpected(reservation.error());
  const auto stored = std::make_shared<ReservedFile>(place.folder, *std::move(reservation));
  static_cast<void>(stored->file.put(std::as_bytes(std::span(bytes))));
  return StoredMesh{.body = body_of(SharedFile(stored, &stored->file), bytes.size()),
                    .fields = std::move(header.fields)};
}

}  // namespace multitetra

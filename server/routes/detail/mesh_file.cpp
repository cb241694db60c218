#include "server/routes/detail/mesh_file.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/painted_mesh.hpp"
#include "common/request/request_notices.hpp"
#include "common/wire/scene_file.hpp"
#include "common/wire/surface_file.hpp"

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

void add_removal_notices(HttpResponse& response, const OutputSurface& output) {
  if (output.components == output.total_components) return;
  if (output.components == 0) {
    add_field(
        response, "Multitetra-Notice",
        "The surface is empty: min_component removes all its components; the longest diagonal "
        "is " +
            rounded_text(output.longest_diagonal) + " samples.");
  } else if (output.filled.count > 0) {
    add_field(response, "Multitetra-Notice", "min_component: " + filled_text(output.filled) + ".");
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

SurfaceName name_of(const DatasetInfo& info, double isovalue, bool is_of_several) {
  const SurfaceName name = surface_name(info);
  if (!is_of_several) return name;
  return {.text = "isovalue " + shortest_text(isovalue), .label = name.label};
}

Result<StoredMesh> stored(std::string bytes, const MeshStorage& place, std::string fields) {
  if (bytes.size() <= place.max_in_memory) {
    return StoredMesh{.body = body_of(std::make_shared<const std::string>(std::move(bytes))),
                      .fields = std::move(fields)};
  }
  auto reservation = place.reservation(bytes.size());
  if (!reservation) return tl::unexpected(reservation.error());
  const auto file = std::make_shared<ReservedFile>(place.folder, *std::move(reservation));
  static_cast<void>(file->file.put(std::as_bytes(std::span(bytes))));
  return StoredMesh{.body = body_of(SharedFile(file, &file->file), bytes.size()),
                    .fields = std::move(fields)};
}

}  // namespace

Result<StoredMesh> store_mesh(std::vector<Surface> surfaces, const DatasetInfo& info,
                              const MeshFileOptions& form, const MeshStorage& place,
                              const std::stop_token& stop) {
  HttpResponse header;
  Totals all;
  const OutputSpace space = form.is_in_world
                                ? OutputSpace{.map = grid_to_world(info), .world = info.meaning}
                                : OutputSpace{.map = grid_to_index(info)};
  std::vector<OutputSurface> outputs;
  outputs.reserve(surfaces.size());
  std::vector<NamedSurface> named;
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
    OutputSurface& output =
        outputs.emplace_back(output_surface(surface.mesh, form.min_component, space, info));
    surface.mesh = {};
    all.components_written += output.components;
    add_removal_notices(header, output);
    paint(output.mesh, surface.scalars, form.colors);
    for (const auto& text : left_out_notices(output.mesh, form.format)) {
      add_field(header, "Multitetra-Notice", text);
    }
    if (form.codec == MeshCodec::kMeshopt && form.is_in_world) {
      rounding = std::max(rounding, position_rounding(output.mesh));
    }
    named.push_back({name_of(info, surface.request.isovalue, surfaces.size() > 1), &output});
  }
  all.error_bound += rounding;
  add_facts(header, all);
  add_world(header, space.world);
  try {
    SurfaceFile file = surface_file(named, form.format, form.codec, ReadBack::kElements);
    return stored(std::move(file.bytes), place, std::move(header.fields));
  } catch (const MeshCoordinatesError& error) {
    return fail(ErrorCode::kInvalidArgument, error.what());
  }
}

}  // namespace multitetra

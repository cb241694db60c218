#include "common/wire/surface_file.hpp"

#include <algorithm>

#include "common/mesh/components.hpp"
#include "common/wire/detail/three_mf_file.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {

namespace {

// Turns normals, which are gradients: with the transpose of the map back, `to_world`.
void turn_normals(std::vector<UnitVector>& normals, const Affine& to_world) {
  for (UnitVector& normal : normals) {
    const Vec3 old = {normal[0], normal[1], normal[2]};
    Vec3 turned;
    for (std::size_t axis = 0; axis < 3; ++axis) turned[axis] = dot(to_world.columns[axis], old);
    if (!(length(turned) > 0)) continue;
    turned = scaled(turned, length(old) / length(turned));
    for (std::size_t axis = 0; axis < 3; ++axis) normal[axis] = static_cast<float>(turned[axis]);
  }
}

}  // namespace

OutputSurface output_surface(const LatticeMesh& surface, double min_component,
                             const OutputSpace& space, const DatasetInfo& info) {
  const LatticeMesh mesh = in_canonical_order(surface);
  const MeshComponents components = components_of(mesh);
  const double shortest = components.least(min_component);
  OutputSurface output{.mesh = {},
                       .world = space.world,
                       .lattice = mesh.resolution,
                       .min_component = shortest,
                       .components = components.count_at_least(shortest),
                       .total_components = components.diagonals.size()};
  if (!components.diagonals.empty()) {
    output.longest_diagonal = components.diagonals[components.largest()];
  }
  if (output.components == output.total_components) {
    output.mesh = positioned(mesh, space.map);
  } else {
    output.mesh = positioned(with_components(mesh, components, shortest), space.map);
    output.filled = filled_cavities(mesh, components, shortest, grid_to_world(info));
  }
  std::uint32_t number = 0;
  for (const std::uint32_t component : components.of_vertex) {
    const double diagonal = components.diagonals[component];
    if (diagonal < shortest) continue;
    if (diagonal >= output.longest_diagonal / 8) output.large.push_back(number);
    ++number;
  }
  if (const Affine to_world = grid_to_world(info); space.map != to_world) {
    turn_normals(output.mesh.normals, composed(to_world, inverse(space.map)));
  }
  return output;
}

namespace {

std::string bytes_of(std::span<const NamedSurface> surfaces, MeshFormat format, MeshCodec codec) {
  const OutputSurface& first = *surfaces.front().surface;
  if (surfaces.size() == 1) {
    return mesh_file(first.mesh, format,
                     {.name = surfaces.front().name,
                      .lattice = first.lattice,
                      .min_component = first.min_component,
                      .world = first.world,
                      .codec = codec});
  }
  std::vector<ScenePart> parts;
  for (const NamedSurface& one : surfaces) {
    parts.push_back({.name = one.name, .mesh = &one.surface->mesh});
  }
  if (format == MeshFormat::k3mf) {
    return three_mf_file(
        parts, first.world,
        std::string(kMeshFileTitle) + ", lattice " + std::to_string(first.lattice));
  }
  return scene_glb(parts, first.world, codec);
}

}  // namespace

SurfaceFile surface_file(std::span<const NamedSurface> surfaces, MeshFormat format, MeshCodec codec,
                         ReadBack counted) {
  SurfaceFile file{.bytes = bytes_of(surfaces, format, codec),
                   .written = std::vector<WrittenMesh>(surfaces.size())};
  const auto is_empty = [](const NamedSurface& one) { return one.surface->mesh.triangles.empty(); };
  if (std::all_of(surfaces.begin(), surfaces.end(), is_empty)) return file;
  const std::vector<WrittenMesh> found = read_back(file.bytes, format, counted);
  auto next = found.begin();
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (is_empty(surfaces[i])) continue;
    require_same(*next, surfaces[i].surface->mesh);
    file.written[i] = *next++;
  }
  return file;
}

}  // namespace multitetra

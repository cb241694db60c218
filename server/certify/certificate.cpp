#include "server/certify/certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "server/certify/detail/closed_components.hpp"
#include "server/certify/detail/component_partners.hpp"
#include "server/certify/detail/missing_components.hpp"
#include "server/certify/detail/reference_surface.hpp"
#include "server/certify/detail/suggested_map.hpp"
#include "server/dataset/dataset.hpp"

namespace multitetra {
namespace {

// In voxels: the gap between the bounds of a maximum, and the distance that counts as the border,
// apart from the allowed rounding.
constexpr double kTolerance = 0.01;

// Without an allowed error: the distance in voxels within which a component of the full surface
// counts as present in the mesh. It is not the default error of requests, because the mesh may have
// been made with any error or by another program.
constexpr double kMissingComponentVoxels = 1;

// The places where the mesh may be open: near the border of the data and near void samples.
class OpenPlaces {
 public:
  // `moved`: vertices may have moved by this, in world units.
  OpenPlaces(const Field& field, const DatasetInfo& grid, double moved)
      : field_(field),
        tolerance_(kTolerance + moved / voxel_length(grid)),
        has_void_(grid.void_samples > 0),
        to_grid_(inverse(grid_to_world(grid))),
        border_(data_border(grid, /*lattice_resolution=*/0, /*topology_tolerance=*/0)) {}

  [[nodiscard]] bool contain_edge(const Vec3& a, const Vec3& b) const {
    const Vec3 p = to_grid_(a);
    const Vec3 q = to_grid_(b);
    const std::array<std::int32_t, 3> low = {border_.low.x, border_.low.y, border_.low.z};
    const std::array<std::int32_t, 3> high = {border_.high.x, border_.high.y, border_.high.z};
    const auto both_are_at = [&](std::size_t axis, std::int32_t side) {
      return std::max(std::abs(p[axis] - side), std::abs(q[axis] - side)) <= tolerance_;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (both_are_at(axis, low[axis]) || both_are_at(axis, high[axis])) return true;
    }
    return has_void_ && is_near_void(p) && is_near_void(q);
  }

 private:
  // Returns whether a sample of the tetrahedra around p, within two grid steps, is void.
  [[nodiscard]] bool is_near_void(const Vec3& p) const {
    GridPoint low;
    for (const double coordinate : p) {
      if (!(std::abs(coordinate) < 1e6)) return false;
    }
    low.x = static_cast<std::int32_t>(std::floor(p[0])) - 1;
    low.y = static_cast<std::int32_t>(std::floor(p[1])) - 1;
    low.z = static_cast<std::int32_t>(std::floor(p[2])) - 1;
    return field_.visit([&](const auto& sampled) {
      for (std::int32_t i = 0; i < 64; ++i) {
        if (is_void(sampled.at(low + GridPoint{i % 4, i / 4 % 4, i / 16}))) return true;
      }
      return false;
    });
  }

  const Field& field_;
  double tolerance_;  // In grid steps.
  bool has_void_;
  Affine to_grid_;
  DataBorder border_;
};

// Returns the largest displacement of a vertex by rounding to 32-bit floats.
double float_rounding(const TriangleMesh& mesh) {
  double largest = 0;
  for (const Vec3& vertex : mesh.vertices) {
    for (const double coordinate : vertex) largest = std::max(largest, std::abs(coordinate));
  }
  return std::sqrt(3.0) * 0x1p-24 * largest;
}

std::uint64_t vertices_beyond_data(const TriangleMesh& mesh, const Volume& volume) {
  const Affine to_index = inverse(volume.index_to_world);
  const auto is_beyond = [&](const Vec3& vertex) {
    const Vec3 index = to_index(vertex);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_between =
          index[axis] >= -kTolerance && index[axis] <= volume.dims[axis] - 1 + kTolerance;
      if (!is_between) return true;
    }
    return false;
  };
  return static_cast<std::uint64_t>(
      std::count_if(mesh.vertices.begin(), mesh.vertices.end(), is_beyond));
}

ErrorVerdict verdict(const Certificate& certificate, double allowed) {
  if (certificate.maximum() > allowed) return ErrorVerdict::kExceeded;
  return certificate.maximum_at_most() <= allowed ? ErrorVerdict::kProven
                                                  : ErrorVerdict::kUndecided;
}

}  // namespace

double Certificate::maximum() const {
  return std::max(distance.mesh_to_reference.maximum, distance.reference_to_mesh.maximum);
}

double Certificate::maximum_at_most() const {
  return std::max(distance.mesh_to_reference.maximum_at_most,
                  distance.reference_to_mesh.maximum_at_most);
}

bool Certificate::is_watertight() const {
  return mesh.open_edges == 0 && mesh.border_edges == 0 && mesh.nonmanifold_edges == 0;
}

bool Certificate::keeps_topology() const {
  return mesh.is_sound() && nonmanifold_vertices <= nonmanifold_vertices_of_reference &&
         mesh.components == reference.components &&
         mesh.euler_characteristic == reference.euler_characteristic;
}

bool Certificate::passes() const {
  return error != ErrorVerdict::kExceeded &&
         (!is_topology_required || (keeps_topology() && keeps_components()));
}

Certificate certify(const TriangleMesh& mesh, const Volume& volume, const CertifyOptions& options) {
  const auto begin = [&](const char* stage) {
    throw_if_stopped(options.stop);
    if (options.on_stage) options.on_stage(stage);
  };
  if (grid_exponent_for(volume.dims, options.margin) > kMaxGridExponent) {
    throw std::invalid_argument(
        "The volume with its margin has more than 2^14 grid steps on an axis.");
  }
  begin("full surface");
  Certificate certificate;
  certificate.grid = grid_info(volume, options.outside, options.margin);
  certificate.is_topology_required = !options.any_topology && !options.within;
  const Field field(volume, options.outside, options.margin);
  WeldedMesh own = welded(mesh);
  if (options.is_inside_out) {
    for (TriangleIndices& t : own.mesh.triangles) std::swap(t[1], t[2]);
  }
  const double voxel = voxel_length(certificate.grid);
  const double float_rounding = multitetra::float_rounding(own.mesh);
  if (mesh.has_floats) certificate.rounding = float_rounding;
  if (options.allow_rounding) certificate.rounding_allowance = certificate.rounding;
  if (options.lattice) {
    certificate.lattice_allowance = lattice_rounding_world(certificate.grid, *options.lattice);
  }
  const double allowed = options.error.value_or(kMissingComponentVoxels * voxel) +
                         certificate.lattice_allowance + certificate.rounding_allowance;
  throw_if_stopped(options.stop);
  const MeshComponents components =
      components_of(own.mesh, inverse(grid_to_world(certificate.grid)));
  ChooseComponents choose;
  if (options.min_component > 0) {
    choose = ExpectedComponents{own.mesh, components, options.min_component, allowed, voxel};
  }
  const ReferenceSurface reference =
      reference_surface(field, certificate.grid, options.isovalue, choose, options.stop);
  certificate.reference = reference.topology;
  certificate.closed_of_reference = counts_of(reference.facings);
  for (const double diagonal : reference.removed_diagonals) {
    if (diagonal < options.min_component) continue;
    ++certificate.left_out.count;
    certificate.left_out.largest_diagonal =
        std::max(certificate.left_out.largest_diagonal, diagonal);
  }
  throw_if_stopped(options.stop);
  certificate.nonmanifold_vertices_of_reference =
      nonmanifold_vertices(reference.mesh.vertices.size(), reference.mesh.triangles);

  begin("topology");
  certificate.degenerate_triangles = own.degenerate_triangles;
  certificate.vertices_beyond_data = vertices_beyond_data(own.mesh, volume);
  const OpenPlaces open_places(field, certificate.grid, certificate.rounding_allowance);
  std::vector<char> is_open(components.diagonals.size(), 0);
  certificate.mesh =
      topology(own.mesh.vertices.size(), own.mesh.triangles, [&](std::uint32_t a, std::uint32_t b) {
        is_open[components.of_vertex[a]] = 1;
        return open_places.contain_edge(own.mesh.vertices[a], own.mesh.vertices[b]);
      });
  throw_if_stopped(options.stop);
  const std::vector<Facing> facings = facings_of(own.mesh, components, is_open, float_rounding);
  certificate.closed = counts_of(facings);
  throw_if_stopped(options.stop);
  certificate.nonmanifold_vertices =
      nonmanifold_vertices(own.mesh.vertices.size(), own.mesh.triangles);

  begin("distances");
  DistanceSearch search{
      .samples = options.samples, .tolerance = kTolerance * voxel, .stop = options.stop};
  if (options.error) search.limit = allowed;
  if (options.within && clipped(own.mesh, *options.within).triangles.empty() &&
      clipped(reference.mesh, *options.within).triangles.empty()) {
    throw std::invalid_argument("--box: neither surface has a part inside this box.");
  }
  certificate.distance = two_sided_distance(own.mesh, reference.mesh, search, options.within);
  if (search.limit) certificate.error = verdict(certificate, *search.limit);
  if (certificate.is_topology_required && certificate.keeps_topology() &&
      certificate.error != ErrorVerdict::kExceeded) {
    const double within = options.error ? allowed : certificate.maximum_at_most();
    certificate.faults = compared_components(
        {own.mesh, components, facings}, {reference.mesh, reference.components, reference.facings},
        within, voxel);
  }
  if (options.try_maps && certificate.maximum() > std::max(allowed, voxel)) {
    certificate.suggestion = suggested_map(own.mesh, reference.mesh, certificate.grid, allowed);
  }
  const bool is_mesh_near = certificate.distance.mesh_to_reference.maximum <= allowed;
  if (!certificate.passes() && is_mesh_near && !options.within) {
    certificate.missing = missing_components(reference, own.mesh, components, allowed);
  }
  if (options.count_self_intersections) {
    begin("self-intersections");
    certificate.self_intersections = self_intersections(own.mesh, options.stop);
  }
  return certificate;
}

}  // namespace multitetra

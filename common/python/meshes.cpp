#include "common/python/meshes.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <utility>

#include "common/python/arrays.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

py::object world_vertices(const LatticeMesh& mesh, const Affine& grid_to_world) {
  const double step = std::ldexp(1.0, -mesh.resolution);
  return new_rows<double>(mesh.vertices.size(), [&](std::size_t i) {
    const LatticePoint& v = mesh.vertices[i];
    return grid_to_world({v.x * step, v.y * step, v.z * step});
  });
}

py::object facing_low_values(const LatticeMesh& mesh, bool is_mirrored) {
  return new_rows<std::uint32_t>(mesh.triangles.size(), [&](std::size_t i) {
    TriangleIndices face = mesh.triangles[i];
    if (is_mirrored) std::swap(face[1], face[2]);
    return face;
  });
}

py::object certificate_of(const SurfaceFacts& facts, int resolution) {
  const MeshTopology& topology = facts.topology;
  py::object self_intersections = py::none();
  if (facts.is_intersection_free) self_intersections = py::int_(0);
  return py::module_::import("multitetra.mesh")
      .attr("Certificate")(
          "error_bound"_a = facts.error_bound, "topology_kept"_a = facts.preserves_topology,
          "euler_characteristic"_a = topology.euler_characteristic,
          "components"_a = topology.components, "border_edges"_a = topology.border_edges,
          "open_edges"_a = topology.open_edges, "nonmanifold_edges"_a = topology.nonmanifold_edges,
          "degenerate_triangles"_a = topology.degenerate_triangles,
          "self_intersecting_triangles"_a = self_intersections, "lattice"_a = resolution,
          "content_digest"_a = facts.digest.hex());
}

}  // namespace

py::object mesh_of(const LatticeMesh& mesh, const Affine& grid_to_world,
                   const SurfaceFacts& facts) {
  py::object normals = py::none();
  if (!mesh.normals.empty()) normals = rows_of<float>(mesh.normals);
  py::object scalars = py::none();
  if (!mesh.scalars.empty()) {
    scalars =
        py::array_t<float>(static_cast<py::ssize_t>(mesh.scalars.size()), mesh.scalars.data());
  }
  return py::module_::import("multitetra.mesh")
      .attr("Mesh")(world_vertices(mesh, grid_to_world),
                    facing_low_values(mesh, grid_to_world.determinant() < 0), normals, scalars,
                    facts.error_bound, facts.is_full_resolution,
                    certificate_of(facts, mesh.resolution));
}

}  // namespace multitetra

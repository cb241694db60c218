#include "common/python/meshes.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/python/arrays.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

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

// Calls body(0) ... body(count - 1) on all threads.
template <typename Body>
void in_tasks(std::size_t count, const Body& body) {
  constexpr std::size_t kTask = 1 << 15;
  in_parallel((count + kTask - 1) / kTask, [&](std::size_t task) {
    const std::size_t end = std::min(count, (task + 1) * kTask);
    for (std::size_t i = task * kTask; i < end; ++i) body(i);
  });
}

}  // namespace

WorldVertices world_vertices(const LatticeMesh& mesh, const Affine& grid_to_world) {
  const double step = std::ldexp(1.0, -mesh.resolution);
  const std::size_t count = mesh.vertices.size();
  WorldVertices vertices(count);
  in_tasks(count, [&](std::size_t i) {
    const LatticePoint& v = mesh.vertices[i];
    vertices.data()[i] = grid_to_world({v.x * step, v.y * step, v.z * step});
  });
  return vertices;
}

py::object mesh_of(LatticeMesh mesh, WorldVertices vertices, const Affine& grid_to_world,
                   const SurfaceFacts& facts) {
  if (grid_to_world.determinant() < 0) {
    in_tasks(mesh.triangles.size(),
             [&](std::size_t i) { std::swap(mesh.triangles[i][1], mesh.triangles[i][2]); });
  }
  py::object normals = py::none();
  if (!mesh.normals.empty()) normals = rows_of<float>(std::move(mesh.normals));
  py::object scalars = py::none();
  if (!mesh.scalars.empty()) {
    scalars =
        py::array_t<float>(static_cast<py::ssize_t>(mesh.scalars.size()), mesh.scalars.data());
  }
  return py::module_::import("multitetra.mesh")
      .attr("Mesh")(rows_of<double>(std::move(vertices)),
                    rows_of<std::uint32_t>(std::move(mesh.triangles)), normals, scalars,
                    facts.error_bound, facts.is_full_resolution,
                    certificate_of(facts, mesh.resolution), facts.length_unit, facts.space);
}

}  // namespace multitetra

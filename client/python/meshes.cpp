#include "client/python/meshes.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "client/python/errors.hpp"
#include "common/dataset/length_units.hpp"
#include "common/python/arrays.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/written_mesh.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

// Returns a hundredth of the shortest edge, which keeps distinct vertices apart.
Vec3 rounding_limits(const PositionedMesh& mesh) {
  double shortest = kAnyRounding;
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double edge = length(difference(mesh.positions[t[i]], mesh.positions[t[(i + 1) % 3]]));
      if (edge > 0) shortest = std::min(shortest, edge);
    }
  }
  return {kMaxVertexRounding * shortest, kMaxVertexRounding * shortest,
          kMaxVertexRounding * shortest};
}

using Scalars = py::array_t<float, py::array::c_style | py::array::forcecast>;

// The path's suffix determines the format.
void save_mesh(const std::string& path, const Rows<double>& vertices,
               const Rows<std::uint32_t>& faces, const std::optional<Rows<float>>& normals,
               const std::optional<Scalars>& scalars, const std::string& unit,
               const std::string& space, std::optional<int> lattice) {
  const auto format = mesh_format_from(std::filesystem::path(path).extension().string());
  if (!format) {
    raise(PyExc_ValueError, "\"" + path +
                                "\" is not the name of a mesh file; mesh files are *.ply, *.stl, "
                                "*.obj, *.glb, *.3mf, *.drc and *.vtp.");
  }
  PositionedMesh mesh{.positions = rows_from(vertices, "Vertices"),
                      .triangles = rows_from(faces, "Faces")};
  for (const TriangleIndices& face : mesh.triangles) {
    for (const std::uint32_t corner : face) {
      if (corner >= mesh.positions.size()) {
        raise(PyExc_ValueError, "A face refers to vertex " + std::to_string(corner) +
                                    ", but the number of vertices is " +
                                    std::to_string(mesh.positions.size()) + ".");
      }
    }
  }
  for (const Vec3& vertex : mesh.positions) {
    if (std::isfinite(vertex[0]) && std::isfinite(vertex[1]) && std::isfinite(vertex[2])) continue;
    raise(PyExc_ValueError, "A vertex has a coordinate that is not finite.");
  }
  if (mesh.triangles.empty() && *format == MeshFormat::kDrc) {
    raise(PyExc_ValueError, "Draco files cannot hold a mesh without triangles; save it as .ply.");
  }
  if (normals) mesh.normals = rows_from(*normals, "Normals");
  if (scalars && scalars->ndim() != 1) {
    raise(PyExc_ValueError,
          "Scalars have one axis; these have " + std::to_string(scalars->ndim()) + ".");
  }
  if (scalars) mesh.scalars.assign(scalars->data(), scalars->data() + scalars->size());
  const std::size_t count = mesh.positions.size();
  if ((normals && mesh.normals.size() != count) || (scalars && mesh.scalars.size() != count)) {
    raise(PyExc_ValueError, "There must be one normal and one scalar for each vertex.");
  }
  mesh.rounding_limits = rounding_limits(mesh);
  for (const std::string& notice : left_out_notices(mesh, *format)) {
    if (PyErr_WarnEx(PyExc_UserWarning, notice.c_str(), 1) != 0) throw py::error_already_set();
  }
  try {
    const MeshFileFacts facts{
        .lattice = lattice,
        .world = {.space = world_space_from(space).value_or(WorldSpace::kUnnamed),
                  .length_unit = unit_from(unit)}};
    const std::string bytes = mesh_file(mesh, *format, facts);
    if (!mesh.triangles.empty()) {
      require_same(read_back(bytes, *format).front(), welded_topology(mesh));
    }
    write_file(path, bytes);
  } catch (const MeshCoordinatesError& problem) {
    raise(PyExc_ValueError,
          problem.what() + (" Here: mesh.vertices += (" + problem.shift + ") before."));
  } catch (const std::system_error& problem) {
    raise(PyExc_OSError, problem.what());
  }
}

}  // namespace

void define_meshes(py::module_& module) { module.def("save_mesh", &save_mesh); }

}  // namespace multitetra

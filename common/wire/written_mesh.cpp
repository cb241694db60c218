#include "common/wire/written_mesh.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "common/mesh/triangle_mesh.hpp"
#include "common/wire/detail/vtp_file.hpp"
#include "common/wire/mesh_readers.hpp"

namespace multitetra {
namespace {

TriangleMesh mesh_in(std::string_view file, MeshFormat format, std::vector<std::size_t>& first) {
  first = {0};
  switch (format) {
    case MeshFormat::kPly:
      return read_ply(file);
    case MeshFormat::kStl:
      return read_stl(file);
    case MeshFormat::kObj:
      return read_obj(file);
    case MeshFormat::kGlb:
      first.clear();
      return read_glb(file, &first);
    case MeshFormat::k3mf:
      first.clear();
      return read_three_mf_model(three_mf_model(file), &first);
    case MeshFormat::kVtp:
      return read_own_vtp(file);
    case MeshFormat::kDrc:
      return file.empty() ? TriangleMesh() : read_draco(file);  // Empty: no triangles.
  }
  return {};
}

WrittenMesh found_in(const TriangleMesh& mesh, ReadBack counted) {
  const WeldedMesh welded_mesh = welded(mesh);
  const TriangleMesh& found = welded_mesh.mesh;
  WrittenMesh written;
  written.topology.vertices = static_cast<std::int64_t>(found.vertices.size());
  written.topology.triangles = static_cast<std::int64_t>(found.triangles.size());
  if (counted != ReadBack::kElements) {
    written.topology = topology(found.vertices.size(), found.triangles,
                                [](std::uint32_t, std::uint32_t) { return true; });
  }
  written.topology.degenerate_triangles =
      static_cast<std::int64_t>(welded_mesh.degenerate_triangles);
  if (counted == ReadBack::kSelfIntersections)
    written.self_intersections = self_intersections(found);
  return written;
}

}  // namespace

std::vector<WrittenMesh> read_back(std::string_view file, MeshFormat format, ReadBack counted) {
  std::vector<std::size_t> first;
  TriangleMesh all = mesh_in(file, format, first);
  if (first.size() == 1) return {found_in(all, counted)};
  std::vector<WrittenMesh> written;
  first.push_back(all.triangles.size());
  for (std::size_t i = 0; i + 1 < first.size(); ++i) {
    const auto begin = all.triangles.begin();
    const TriangleMesh part = {.vertices = all.vertices,
                               .triangles = {begin + static_cast<std::ptrdiff_t>(first[i]),
                                             begin + static_cast<std::ptrdiff_t>(first[i + 1])}};
    written.push_back(found_in(part, counted));
  }
  return written;
}

namespace {

[[noreturn]] void fail_to_hold(const MeshTopology& found, std::int64_t triangles,
                               std::int64_t vertices) {
  throw std::logic_error("Internal error: a mesh of " + std::to_string(triangles) +
                         " triangles and " + std::to_string(vertices) +
                         " vertices would be written with " + std::to_string(found.triangles) +
                         " triangles, " + std::to_string(found.vertices) + " vertices and " +
                         std::to_string(found.degenerate_triangles) +
                         " degenerate triangles. Please report it; another format may hold it.");
}

}  // namespace

void require_same(const WrittenMesh& written, const PositionedMesh& mesh) {
  const MeshTopology& found = written.topology;
  const auto triangles = static_cast<std::int64_t>(mesh.triangles.size());
  const auto vertices = static_cast<std::int64_t>(mesh.positions.size());
  const bool is_same =
      found.degenerate_triangles == 0 && found.triangles == triangles && found.vertices == vertices;
  if (!is_same) fail_to_hold(found, triangles, vertices);
}

MeshTopology welded_topology(const PositionedMesh& mesh) {
  return found_in({.vertices = mesh.positions, .triangles = mesh.triangles}, ReadBack::kTopology)
      .topology;
}

void require_same(const WrittenMesh& written, const MeshTopology& expected) {
  const MeshTopology& found = written.topology;
  const bool is_same = found.triangles == expected.triangles && found.edges == expected.edges &&
                       found.border_edges == expected.border_edges &&
                       found.nonmanifold_edges == expected.nonmanifold_edges;
  if (!is_same) fail_to_hold(found, expected.triangles, expected.vertices);
}

}  // namespace multitetra

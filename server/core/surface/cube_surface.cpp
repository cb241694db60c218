#include "server/core/surface/cube_surface.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace multitetra {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

}  // namespace

// All entries of `number_of` are kNone between calls.
LatticeMesh part_of(const LatticeMesh& mesh, std::size_t begin, std::size_t end,
                    std::vector<std::uint32_t>& number_of) {
  LatticeMesh part{.resolution = mesh.resolution, .vertices = {}, .triangles = {}};
  part.triangles.reserve(end - begin);
  number_of.resize(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> used;  // The part's vertices by their numbers in the mesh.
  used.reserve((end - begin) / 2 + (end - begin) / 16 + 8);
  for (std::size_t i = begin; i < end; ++i) {
    TriangleIndices triangle = mesh.triangles[i];
    for (std::uint32_t& corner : triangle) {
      std::uint32_t& number = number_of[corner];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(used.size());
        used.push_back(corner);
      }
      corner = number;
    }
    part.triangles.push_back(triangle);
  }
  part.vertices.reserve(used.size());
  for (const std::uint32_t vertex : used) {
    part.vertices.push_back(mesh.vertices[vertex]);
    number_of[vertex] = kNone;
  }
  return part;
}

LatticeMesh weld(std::span<const TileMesh> tiles, int resolution) {
  std::vector<const LatticeMesh*> meshes;
  for (const TileMesh& tile : tiles) meshes.push_back(&tile.mesh);
  return weld(meshes, resolution);
}

template <typename IsShared>
void CubeSurfaceBuilder::weld(const LatticeMesh& mesh, const IsShared& is_shared) {
  std::vector<std::uint32_t> number_of(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const LatticePoint& vertex = mesh.vertices[i];
    if (is_shared(vertex)) {
      number_of[i] = shared_.number(vertex, mesh_.vertices);
    } else {
      number_of[i] = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(vertex);
    }
  }
  for (const TriangleIndices& t : mesh.triangles) {
    mesh_.triangles.push_back({number_of[t[0]], number_of[t[1]], number_of[t[2]]});
  }
}

void CubeSurfaceBuilder::append(CubeSurface child, const OctreeCube& cube) {
  count(child.tetrahedra, child.active_tetrahedra);
  std::move(child.tiles.begin(), child.tiles.end(), std::back_inserter(surface_.tiles));
  // Only vertices on the border of the child's cube can be shared.
  const std::int32_t within = (1 << (cube.exponent + mesh_.resolution)) - 1;
  weld(child.rest, [within](const LatticePoint& p) {
    return (p.x & within) == 0 || (p.y & within) == 0 || (p.z & within) == 0;
  });
}

void CubeSurfaceBuilder::append(const LatticeMesh& mesh) {
  weld(mesh, [](const LatticePoint&) { return true; });
}

void CubeSurfaceBuilder::cut_off(const OctreeCube& cube, std::size_t begin,
                                 const ChildRanges& ranges) {
  std::size_t remaining = triangles() - begin;
  if (remaining <= max_) return;
  const auto size_of = [&](std::size_t child) { return ranges[child + 1] - ranges[child]; };
  std::array<std::size_t, 8> by_size = {0, 1, 2, 3, 4, 5, 6, 7};
  std::stable_sort(by_size.begin(), by_size.end(),
                   [&](std::size_t a, std::size_t b) { return size_of(a) > size_of(b); });
  std::array<bool, 8> is_cut{};
  for (const std::size_t child : by_size) {
    if (remaining <= max_ || size_of(child) == 0) break;
    is_cut[child] = true;
    remaining -= size_of(child);
  }
  const auto at = [this](std::size_t i) {
    return mesh_.triangles.begin() + static_cast<std::ptrdiff_t>(i);
  };
  auto keep = at(begin);
  for (std::size_t child = 0; child < 8; ++child) {
    if (is_cut[child]) {
      surface_.tiles.push_back({cube.child(static_cast<int>(child)),
                                part_of(mesh_, ranges[child], ranges[child + 1], number_of_)});
    } else {
      keep = std::move(at(ranges[child]), at(ranges[child + 1]), keep);
    }
  }
  keep = std::move(at(ranges[8]), mesh_.triangles.end(), keep);
  mesh_.triangles.erase(keep, mesh_.triangles.end());
}

CubeSurface CubeSurfaceBuilder::take() {
  // If set, the mesh still contains vertices used only by tiles.
  const bool is_cut = !number_of_.empty();
  surface_.rest = is_cut ? part_of(mesh_, 0, triangles(), number_of_) : mesh_;
  return std::move(surface_);
}

}  // namespace multitetra

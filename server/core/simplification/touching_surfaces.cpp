#include "server/core/simplification/touching_surfaces.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "common/mesh/triangle_tree.hpp"

namespace multitetra {
namespace {

// A triangle of a surface with its corners sorted. Triangles with equal corners have opposite
// orientations if just one of them `is_turned`.
struct SortedTriangle {
  std::array<std::uint64_t, 3> corners;
  std::uint32_t surface = 0;
  std::uint32_t triangle = 0;
  bool is_turned = false;

  friend auto operator<=>(const SortedTriangle&, const SortedTriangle&) = default;
};

std::vector<SortedTriangle> sorted_triangles(std::span<const LatticeMesh> surfaces) {
  std::vector<SortedTriangle> all;
  for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
    const LatticeMesh& mesh = surfaces[s];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [p, q, r] = mesh.triangles[t];
      std::array<std::uint64_t, 3> corners = {mesh.vertices[p].key(), mesh.vertices[q].key(),
                                              mesh.vertices[r].key()};
      const bool is_turned =
          (corners[0] > corners[1]) != ((corners[0] > corners[2]) != (corners[1] > corners[2]));
      std::sort(corners.begin(), corners.end());
      all.push_back({corners, s, t, is_turned});
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

LatticeTriangle placed(const LatticeMesh& mesh, const TriangleIndices& triangle) {
  const auto& [p, q, r] = triangle;
  return {mesh.vertices[p], mesh.vertices[q], mesh.vertices[r]};
}

TriangleBox box_of(const LatticeMesh& mesh) {
  TriangleBox box = {mesh.vertices.front(), mesh.vertices.front()};
  for (const LatticePoint& p : mesh.vertices) box = box_around(box, {p, p});
  return box;
}

// The triangles of the other patches that are near enough to be met.
std::vector<LatticeTriangle> triangles_around(std::span<const SurfacePatch> patches,
                                              std::size_t index) {
  const TriangleBox box = box_of(patches[index].mesh);
  std::vector<LatticeTriangle> around;
  for (std::size_t other = 0; other < patches.size(); ++other) {
    if (other == index) continue;
    const LatticeMesh& mesh = patches[other].mesh;
    for (const TriangleIndices& triangle : mesh.triangles) {
      const LatticeTriangle corners = placed(mesh, triangle);
      if (box_of(corners).touches(box)) around.push_back(corners);
    }
  }
  return around;
}

}  // namespace

std::vector<SurfacePatch> patches_of(std::span<const LatticeMesh> surfaces) {
  const std::vector<SortedTriangle> all = sorted_triangles(surfaces);
  std::map<std::array<std::uint32_t, 2>, std::vector<LatticeTriangle>> patches;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const SortedTriangle& here = all[i];
    const bool is_common = i + 1 < all.size() && all[i + 1].corners == here.corners &&
                           all[i + 1].is_turned != here.is_turned;
    const LatticeMesh& mesh = surfaces[here.surface];
    patches[{here.surface, is_common ? all[i + 1].surface : SurfacePatch::kNone}].push_back(
        placed(mesh, mesh.triangles[here.triangle]));
    if (is_common) ++i;
  }
  std::vector<SurfacePatch> result;
  for (const auto& [surfaces_of, triangles] : patches) {
    result.push_back({.first = surfaces_of[0],
                      .second = surfaces_of[1],
                      .mesh = index_triangles(triangles, surfaces.front().resolution)});
  }
  return result;
}

void simplify_patch(std::vector<SurfacePatch>& patches, std::size_t index,
                    const SimplificationOptions& options, const std::function<void()>& checkpoint) {
  SurfacePatch& patch = patches[index];
  if (options.max_distance.largest() == 0) return;
  std::vector<LatticeTriangle> around;
  std::optional<Obstacles> obstacles;
  if (options.is_intersection_free) {
    around = triangles_around(patches, index);
    obstacles = around;
  }
  SimplifiedPiece piece(std::move(patch.mesh), options.lattice_step);
  piece.simplify(options.max_distance, checkpoint, obstacles, 0, true);
  Simplified result = piece.result();
  patch.mesh = std::move(result.mesh);
  patch.bound = result.bound;
}

std::vector<Simplified> joined_patches(std::span<const SurfacePatch> patches,
                                       std::size_t surface_count) {
  std::vector<std::vector<LatticeTriangle>> triangles(surface_count);
  std::vector<double> bounds(surface_count, 0);
  for (const SurfacePatch& patch : patches) {
    for (const TriangleIndices& triangle : patch.mesh.triangles) {
      const LatticeTriangle corners = placed(patch.mesh, triangle);
      triangles[patch.first].push_back(corners);
      if (patch.second == SurfacePatch::kNone) continue;
      triangles[patch.second].push_back({corners[0], corners[2], corners[1]});
    }
    bounds[patch.first] = std::max(bounds[patch.first], patch.bound);
    if (patch.second != SurfacePatch::kNone)
      bounds[patch.second] = std::max(bounds[patch.second], patch.bound);
  }
  std::vector<Simplified> surfaces;
  const int resolution =
      patches.empty() ? kDefaultLatticeResolution : patches.front().mesh.resolution;
  for (std::size_t s = 0; s < surface_count; ++s) {
    surfaces.push_back({.mesh = index_triangles(triangles[s], resolution), .bound = bounds[s]});
  }
  return surfaces;
}

}  // namespace multitetra

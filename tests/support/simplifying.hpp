// Surfaces to simplify, and checks of the guarantees of simplification.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "tests/support/distance_statistics.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/isosurfaces.hpp"

namespace multitetra::testing {

struct Setting {
  const char* name;
  Volume volume;
  std::optional<double> outside;
  double isovalue;
};

inline std::ostream& operator<<(std::ostream& out, const Setting& setting) {
  return out << setting.name;
}

inline std::vector<Setting> settings() {
  return {
      {"noise", fields::noise({17, 17, 17}, 41), std::nullopt, 0.3},
      {"closed_noise", fields::noise({14, 15, 12}, 42), 0.0, 0.6},
      {"flat_noise", fields::noise({21, 6, 9}, 43, {0.5, 1, 3}), 0.0, 0.4},
      {"plateaus", fields::integer_noise({17, 16, 15}, 5, 44), std::nullopt, 1.5},
      {"gyroid", fields::gyroid(21, 0, 45), std::nullopt, 0.1},
      {"noisy_gyroid", fields::gyroid(21, 0.8, 46, {1, 1, 2}), std::nullopt, 0.1},
      {"ball", fields::ball({20, 24, 17}, 7), std::nullopt, 0.0},
      {"masked_gyroid", fields::masked_gyroid(16, 47), std::nullopt, 0.05},
  };
}

inline const DataBorder kAnywhere = {.low = {}, .high = {}, .anywhere = true};

inline Vec3 step_of(const Volume& volume) {
  Vec3 step;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    step[axis] = volume.spacing[axis] / (1 << kDefaultLatticeResolution);
  }
  return step;
}

inline std::vector<SurfaceTriangle> placed(const LatticeMesh& mesh, const Vec3& step) {
  std::vector<SurfaceTriangle> surface;
  for (const TriangleIndices& t : mesh.triangles) {
    SurfaceTriangle& triangle = surface.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint& p = mesh.vertices[t[i]];
      triangle[i] = {step[0] * p.x, step[1] * p.y, step[2] * p.z};
    }
  }
  return surface;
}

inline double largest_distance(const std::vector<SurfaceTriangle>& from,
                               const std::vector<SurfaceTriangle>& to) {
  const auto anything = [](const Vec3&) { return 1e300; };
  return distances(sampled_points(from, 6000), NearestTriangle(to), anything).maximum;
}

using Edge = std::array<LatticePoint, 2>;
// Returns the edges of one triangle, in the triangle's direction.
inline std::multiset<Edge> border_edges(const LatticeMesh& mesh) {
  std::multiset<Edge> edges;
  for (const TriangleIndices& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const LatticePoint& a = mesh.vertices[t[i]];
      const LatticePoint& b = mesh.vertices[t[(i + 1) % 3]];
      if (const auto back = edges.find({b, a}); back != edges.end()) {
        edges.erase(back);
      } else {
        edges.insert({a, b});
      }
    }
  }
  return edges;
}

// Returns six times the volumes of the components, exactly; NaN for open ones.
inline std::vector<double> volumes_of_closed(const LatticeMesh& mesh,
                                             const MeshComponents& components) {
  std::vector<double> volumes(components.diagonals.size());
  std::set<LatticePoint> border;
  for (const Edge& edge : border_edges(mesh)) border.insert(edge.begin(), edge.end());
  const auto triangles = placed(mesh, {1, 1, 1});
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::uint32_t component = components.of_vertex[mesh.triangles[i][0]];
    volumes[component] += dot(triangles[i][0], cross(triangles[i][1], triangles[i][2]));  // Exact.
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (border.contains(mesh.vertices[v])) {
        volumes[component] = std::numeric_limits<double>::quiet_NaN();
      }
    }
  }
  return volumes;
}

// Returns the number of vertices of a simplified surface in components that were turned inside out.
// Its vertices are some of those of the whole surface, which name the component.
inline int inverted_vertices(const LatticeMesh& small, const LatticeMesh& whole) {
  const MeshComponents components = components_of(whole);
  const std::vector<double> volumes = volumes_of_closed(whole, components);
  std::map<LatticePoint, double> volume_at;
  for (std::size_t v = 0; v < whole.vertices.size(); ++v) {
    volume_at[whole.vertices[v]] = volumes[components.of_vertex[v]];
  }
  const MeshComponents parts = components_of(small);
  const std::vector<double> now = volumes_of_closed(small, parts);
  int inverted = 0;
  for (std::size_t v = 0; v < small.vertices.size(); ++v) {
    if (now[parts.of_vertex[v]] * volume_at.at(small.vertices[v]) < 0) ++inverted;
  }
  return inverted;
}

inline bool is_subset(const LatticeMesh& some, const LatticeMesh& all) {
  const std::set<LatticePoint> known(all.vertices.begin(), all.vertices.end());
  return std::all_of(some.vertices.begin(), some.vertices.end(),
                     [&](const LatticePoint& p) { return known.contains(p); });
}

inline constexpr double kDistances[] = {0.05, 0.25, 1, 1e6};

class SimplificationGuarantees : public ::testing::TestWithParam<Setting> {
 protected:
  const Setting& setting_ = GetParam();
  Vec3 step_ = step_of(setting_.volume);
  ReferenceIsosurfaces isosurfaces_{setting_.volume, setting_.outside, 0};
  Surface surface_ = isosurfaces_({.isovalue = setting_.isovalue, .threshold = 0});
};

}  // namespace multitetra::testing

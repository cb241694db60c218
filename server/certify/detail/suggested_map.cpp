#include "server/certify/detail/suggested_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/number_text.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kSamples = 300;

// A map is worth telling if it leaves at most this part of the distance.
constexpr double kMinImprovement = 0.5;

struct Candidate {
  std::string option;
  Affine map;
};

Affine scaling(const Vec3& factors) {
  return {.columns = {Vec3{factors[0], 0, 0}, Vec3{0, factors[1], 0}, Vec3{0, 0, factors[2]}}};
}

std::vector<Candidate> candidates(const DatasetInfo& grid) {
  std::string turned = "x and y negated (LPS and RAS)";
  if (grid.meaning.space == WorldSpace::kLps) turned = "--space ras";
  if (grid.meaning.space == WorldSpace::kRas) turned = "--space lps";
  std::vector<Candidate> all = {{turned, scaling({-1, -1, 1})},
                                {"--coordinates index", grid.index_to_world}};
  for (const double scale : {1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9, 10.0, 0.1, 100.0, 0.01, 25.4}) {
    const std::string option = "--scale " + shortest_text(scale);
    all.push_back({option, scaling({scale, scale, scale})});
    all.push_back({option + " and " + turned, scaling({-scale, -scale, scale})});
  }
  // y-up to z-up, as of viewers, and back.
  all.push_back(
      {"y and z exchanged (y up)", {.columns = {Vec3{1, 0, 0}, Vec3{0, 0, 1}, Vec3{0, -1, 0}}}});
  if (const Vec3& origin = grid.index_to_world.translation; origin != Vec3{}) {
    const Vec3 shift = difference({}, origin);
    all.push_back({"--shift " + shortest_text(shift[0]) + ',' + shortest_text(shift[1]) + ',' +
                       shortest_text(shift[2]) + " (the first sample as the origin)",
                   {.translation = origin}});
  }
  return all;
}

// Returns the largest distance of some vertices, mapped, from the other surface; stops beyond
// `max_distance`.
double sampled_distance(const TriangleMesh& mesh, const Affine& map, const NearestTriangle& other,
                        double max_distance) {
  double farthest = 0;
  const std::size_t step = 1 + mesh.vertices.size() / kSamples;
  for (std::size_t i = 0; i < mesh.vertices.size() && farthest <= max_distance; i += step) {
    farthest = std::max(farthest, other.distance(map(mesh.vertices[i])));
  }
  return farthest;
}

TriangleMesh mapped(TriangleMesh mesh, const Affine& map) {
  for (Vec3& vertex : mesh.vertices) vertex = map(vertex);
  return mesh;
}

}  // namespace

std::optional<MapSuggestion> suggested_map(const TriangleMesh& mesh, const TriangleMesh& full,
                                           const DatasetInfo& grid, double allowed) {
  if (mesh.triangles.empty() || full.triangles.empty()) return std::nullopt;
  const NearestTriangle to_full(triangles_of(full));
  // Better than as it is, by as much as tells: a map may be nearly none.
  const auto distance_as_it_is = [&] {
    const double there = sampled_distance(mesh, {}, to_full, HUGE_VAL);
    return std::max(there,
                    sampled_distance(full, {}, NearestTriangle(triangles_of(mesh)), HUGE_VAL));
  };
  double least = std::min(allowed + voxel_length(grid), kMinImprovement * distance_as_it_is());
  std::optional<MapSuggestion> best;
  for (const Candidate& candidate : candidates(grid)) {
    double distance = sampled_distance(mesh, candidate.map, to_full, least);
    if (distance > least) continue;
    const NearestTriangle to_mesh(triangles_of(mapped(mesh, candidate.map)));
    distance = std::max(distance, sampled_distance(full, {}, to_mesh, least));
    if (distance > least) continue;
    least = distance;
    best = MapSuggestion{.option = candidate.option, .distance = distance};
  }
  return best;
}

}  // namespace multitetra

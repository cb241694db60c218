#include "server/certify/two_sided_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/base/in_parallel.hpp"
#include "common/mesh/surface_distance.hpp"

namespace multitetra {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxRounds = 16;
constexpr std::size_t kMaxPiecesOfAll = 40;  // Pieces split in all batches, times max_pieces.

using Found = NearestTriangle::Found;

// Returns a bound of the distance from any point of the triangle to `other`, a triangle of the
// other surface.
double bound_by(const SurfaceTriangle& triangle, const SurfaceTriangle& other) {
  double farthest = 0;
  for (const Vec3& corner : triangle) {
    farthest = std::max(farthest, distance_to_triangle(corner, other));
  }
  return farthest;
}

// Returns a bound of the distance from any point of the triangle to the other surface: the least
// over the triangles nearest to the corners.
double bound_of(const SurfaceTriangle& triangle, const std::array<Found, 3>& nearest) {
  double bound = kInfinity;
  for (std::size_t i = 0; i < 3; ++i) {
    double farthest = nearest[i].distance;
    for (std::size_t j = 0; j < 3 && farthest < bound; ++j) {
      if (j == i) continue;
      farthest = std::max(farthest, distance_to_triangle(triangle[j], *nearest[i].triangle));
    }
    bound = std::min(bound, farthest);
  }
  return bound;
}

// A part of a triangle of the surface.
struct Piece {
  SurfaceTriangle corners;
  std::array<Found, 3> nearest;
  double bound = 0;
};

Vec3 middle(const Vec3& a, const Vec3& b) { return scaled(sum(a, b), 0.5); }

// Neighbours in the list are mostly neighbours in space.
std::vector<Found> nearest_of(std::span<const Vec3> points, const NearestTriangle& surface,
                              const std::stop_token& stop) {
  constexpr std::size_t kBlock = 256;
  std::vector<Found> nearest(points.size());
  const auto find_block = [&](std::size_t block) {
    const SurfaceTriangle* near = nullptr;
    const std::size_t end = std::min((block + 1) * kBlock, points.size());
    for (std::size_t i = block * kBlock; i < end; ++i) {
      nearest[i] = surface.nearest(points[i], near);
      near = nearest[i].triangle;
    }
  };
  in_parallel((points.size() + kBlock - 1) / kBlock, find_block, stop);
  return nearest;
}

class MaximumSearch {
 public:
  MaximumSearch(const NearestTriangle& other, const DistanceSearch& search)
      : other_(other), search_(search) {}

  SurfaceDistance run(const TriangleMesh& mesh) {
    const std::vector<std::uint32_t> triangles = undecided_triangles(mesh);
    // A batch at a time needs little memory. The first batches have the largest bounds.
    const std::size_t batch = std::max<std::size_t>(search_.max_pieces / 16, 1);
    std::size_t remaining_pieces = kMaxPiecesOfAll * search_.max_pieces;
    for (std::size_t begin = 0; begin < triangles.size(); begin += batch) {
      const std::size_t end = std::min(begin + batch, triangles.size());
      std::vector<Piece> pieces;
      for (std::size_t i = begin; i < end; ++i) {
        pieces.push_back(piece_of(mesh, triangles[i]));
        pieces.back().bound = bounds_[triangles[i]];
      }
      keep_undecided(pieces);
      for (int round = 0;
           round < kMaxRounds && !pieces.empty() && pieces.size() <= remaining_pieces; ++round) {
        remaining_pieces -= pieces.size();
        pieces = cut(pieces);
        for (const Piece& piece : pieces) {
          for (std::size_t i = 0; i < 3; ++i) record(piece.corners[i], piece.nearest[i].distance);
        }
        keep_undecided(pieces);
      }
      for (const Piece& piece : pieces) dropped_bound_ = std::max(dropped_bound_, piece.bound);
      result_.undecided += pieces.size();
    }
    result_.maximum_at_most = std::max({result_.maximum, settled_bound_, dropped_bound_});
    return result_;
  }

 private:
  void record(const Vec3& point, double distance) {
    if (distance <= result_.maximum) return;
    result_.maximum = distance;
    result_.farthest = point;
  }

  [[nodiscard]] bool is_undecided(double bound) const {
    if (bound > result_.maximum + search_.tolerance) return true;
    return search_.limit && result_.maximum <= *search_.limit && bound > *search_.limit;
  }

  // Where surfaces share vertices, a fan of triangles is nearest to a corner, and any of it is
  // found there; the middle finds the one that runs along.
  [[nodiscard]] double tightened(double bound, const SurfaceTriangle& corners,
                                 const SurfaceTriangle* nearest) const {
    if (!is_undecided(bound)) return bound;
    const Vec3 center = scaled(sum(sum(corners[0], corners[1]), corners[2]), 1.0 / 3);
    return std::min(bound, bound_by(corners, *other_.nearest(center, nearest).triangle));
  }

  [[nodiscard]] Piece piece_of(const TriangleMesh& mesh, std::size_t triangle) const {
    const TriangleIndices& t = mesh.triangles[triangle];
    return {.corners = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]},
            .nearest = {nearest_[t[0]], nearest_[t[1]], nearest_[t[2]]}};
  }

  // Returns the triangles whose interior may be farther than all vertices; largest bounds first.
  std::vector<std::uint32_t> undecided_triangles(const TriangleMesh& mesh) {
    nearest_ = nearest_of(mesh.vertices, other_, search_.stop);
    for (std::size_t i = 0; i < nearest_.size(); ++i) {
      record(mesh.vertices[i], nearest_[i].distance);
    }
    bounds_.resize(mesh.triangles.size());
    const auto find_bound = [&](std::size_t i) {
      const Piece piece = piece_of(mesh, i);
      bounds_[i] = tightened(bound_of(piece.corners, piece.nearest), piece.corners,
                             piece.nearest[0].triangle);
    };
    in_parallel(bounds_.size(), find_bound, search_.stop);
    std::vector<std::uint32_t> undecided;
    for (std::uint32_t i = 0; i < bounds_.size(); ++i) {
      if (is_undecided(bounds_[i])) {
        undecided.push_back(i);
      } else {
        settled_bound_ = std::max(settled_bound_, bounds_[i]);
      }
    }
    std::stable_sort(undecided.begin(), undecided.end(),
                     [&](std::uint32_t i, std::uint32_t j) { return bounds_[i] > bounds_[j]; });
    return undecided;
  }

  void keep_undecided(std::vector<Piece>& pieces) {
    std::erase_if(pieces, [&](const Piece& piece) {
      if (is_undecided(piece.bound)) return false;
      settled_bound_ = std::max(settled_bound_, piece.bound);
      return true;
    });
    if (pieces.size() <= search_.max_pieces) return;
    // Drops those with the smallest bounds.
    std::stable_sort(pieces.begin(), pieces.end(),
                     [](const Piece& a, const Piece& b) { return a.bound > b.bound; });
    dropped_bound_ = std::max(dropped_bound_, pieces[search_.max_pieces].bound);
    result_.undecided += pieces.size() - search_.max_pieces;
    pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(search_.max_pieces), pieces.end());
  }

  [[nodiscard]] std::vector<Piece> cut(const std::vector<Piece>& pieces) const {
    std::vector<Piece> parts(4 * pieces.size());
    const auto cut_one = [&](std::size_t i) {
      const auto& [a, b, c] = pieces[i].corners;
      const auto& [na, nb, nc] = pieces[i].nearest;
      const Vec3 ab = middle(a, b);
      const Vec3 bc = middle(b, c);
      const Vec3 ca = middle(c, a);
      const Found nab = other_.nearest(ab, na.triangle);
      const Found nbc = other_.nearest(bc, nb.triangle);
      const Found nca = other_.nearest(ca, nc.triangle);
      const std::array<Piece, 4> four = {{{{a, ab, ca}, {na, nab, nca}},
                                          {{ab, b, bc}, {nab, nb, nbc}},
                                          {{ca, bc, c}, {nca, nbc, nc}},
                                          {{ab, bc, ca}, {nab, nbc, nca}}}};
      for (std::size_t part = 0; part < 4; ++part) {
        parts[4 * i + part] = four[part];
        const double bound = bound_of(four[part].corners, four[part].nearest);
        parts[4 * i + part].bound = tightened(std::min(pieces[i].bound, bound), four[part].corners,
                                              four[part].nearest[0].triangle);
      }
    };
    in_parallel(pieces.size(), cut_one, search_.stop);
    return parts;
  }

  const NearestTriangle& other_;
  const DistanceSearch& search_;
  SurfaceDistance result_;
  std::vector<Found> nearest_;  // By vertex.
  std::vector<double> bounds_;  // By triangle.
  // The largest bound of pieces that need no further search.
  double settled_bound_ = 0;
  // The largest bound of dropped pieces.
  double dropped_bound_ = 0;
};

void sample(SurfaceDistance& result, std::span<const SurfaceTriangle> triangles,
            const NearestTriangle& other, const DistanceSearch& search) {
  const std::vector<Vec3> points = sampled_points(triangles, search.samples);
  if (points.empty()) return;
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Found& found : nearest_of(points, other, search.stop)) {
    distances.push_back(found.distance);
  }
  result.samples = points.size();
  result.mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
                static_cast<double>(distances.size());
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(distances.size())) - 1);
  std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
  result.percentile_99 = distances[static_cast<std::size_t>(rank)];
}

SurfaceDistance one_sided(const TriangleMesh& mesh, std::span<const SurfaceTriangle> triangles,
                          const NearestTriangle& other, const DistanceSearch& search) {
  if (triangles.empty()) return {};
  if (other.is_empty()) {
    return {.maximum = kInfinity,
            .maximum_at_most = kInfinity,
            .percentile_99 = kInfinity,
            .mean = kInfinity,
            .farthest = triangles.front()[0]};
  }
  SurfaceDistance result = MaximumSearch(other, search).run(mesh);
  sample(result, triangles, other, search);
  return result;
}

}  // namespace

TwoSidedDistance two_sided_distance(const TriangleMesh& mesh, const TriangleMesh& reference,
                                    const DistanceSearch& search,
                                    const std::optional<PlacedBox>& within) {
  if (within) {
    const auto part_from = [&](const TriangleMesh& whole, const TriangleMesh& other) {
      const TriangleMesh part = clipped(whole, *within);
      return one_sided(part, triangles_of(part), NearestTriangle(triangles_of(other)), search);
    };
    return {.mesh_to_reference = part_from(mesh, reference),
            .reference_to_mesh = part_from(reference, mesh)};
  }
  const std::vector<SurfaceTriangle> of_mesh = triangles_of(mesh);
  const std::vector<SurfaceTriangle> of_reference = triangles_of(reference);
  TwoSidedDistance result;
  result.mesh_to_reference = one_sided(mesh, of_mesh, NearestTriangle(of_reference), search);
  result.reference_to_mesh = one_sided(reference, of_reference, NearestTriangle(of_mesh), search);
  return result;
}

}  // namespace multitetra

#include "server/certify/two_sided_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/base/vec3.hpp"
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

// Returns the largest distance of a point of a triangle from its nearest corner: the radius of the
// circle through the corners, or, with an obtuse angle, that of a point on the longest side, as far
// from one of its ends as from the obtuse corner.
double reach_of(const SurfaceTriangle& triangle) {
  std::array<double, 3> squares{};
  for (std::size_t i = 0; i < 3; ++i) {
    squares[i] = squared_length(difference(triangle[i], triangle[(i + 1) % 3]));
  }
  std::ranges::sort(squares);
  const auto [a, b, c] = squares;
  const double area =
      length(cross(difference(triangle[1], triangle[0]), difference(triangle[2], triangle[0])));
  if (a == 0) return std::sqrt(c) / 2;
  if (a + b > c && area > 0) return std::sqrt(a * b * c) / (2 * area);
  return std::sqrt(c) * std::max(a / (a + c - b), b / (b + c - a));
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
  std::uint32_t triangle = 0;  // Its number in the mesh.
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
    find_bounds(mesh);
    std::size_t remaining_pieces = kMaxPiecesOfAll * search_.max_pieces;
    // Whether the maximum exceeds the limit matters more than its last digits, and takes less.
    decides_limit_ = search_.limit && result_.maximum <= *search_.limit;
    if (decides_limit_) search_triangles(mesh, remaining_pieces);
    decides_limit_ = false;
    result_.undecided = 0;
    search_triangles(mesh, remaining_pieces);
    result_.maximum_at_most = std::max(result_.maximum, std::ranges::max(bounds_));
    return result_;
  }

 private:
  // Cuts the triangles while pieces are undecided and some may still be cut; tightens `bounds_`.
  void search_triangles(const TriangleMesh& mesh, std::size_t& remaining_pieces) {
    const std::vector<std::uint32_t> triangles = undecided_triangles();
    // A batch at a time needs little memory; in small ones, few pieces are dropped. The first
    // batches have the largest bounds.
    const std::size_t batch = std::max<std::size_t>(search_.max_pieces / 256, 1);
    for (std::size_t begin = 0; begin < triangles.size(); begin += batch) {
      const std::size_t end = std::min(begin + batch, triangles.size());
      std::vector<Piece> pieces;
      for (std::size_t i = begin; i < end; ++i) {
        pieces.push_back(piece_of(mesh, triangles[i]));
        pieces.back().bound = std::exchange(bounds_[triangles[i]], 0);
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
      for (const Piece& piece : pieces) leave(piece);
      result_.undecided += pieces.size();
    }
  }

  // Adds a piece that is not cut further to its triangle's bound.
  void leave(const Piece& piece) {
    bounds_[piece.triangle] = std::max(bounds_[piece.triangle], piece.bound);
  }

  void record(const Vec3& point, double distance) {
    if (distance <= result_.maximum) return;
    result_.maximum = distance;
    result_.farthest = point;
  }

  [[nodiscard]] bool is_undecided(double bound) const {
    const bool is_beyond =
        search_.limit && result_.maximum <= *search_.limit && bound > *search_.limit;
    return is_beyond || (!decides_limit_ && bound > result_.maximum + search_.tolerance);
  }

  // Returns a lower bound for an undecided piece, by the distance of its middle. Where surfaces
  // share vertices, a fan of triangles is nearest to a corner, and any of it is found there; the
  // middle finds the one that runs along. Where the other surface bends, no point is farther than
  // the nearest of corners and middle and its distance from that.
  [[nodiscard]] double tightened(double bound, const SurfaceTriangle& corners,
                                 const std::array<Found, 3>& nearest) const {
    if (!is_undecided(bound)) return bound;
    const Vec3 center = scaled(sum(sum(corners[0], corners[1]), corners[2]), 1.0 / 3);
    const Found found = other_.nearest(center, nearest[0].triangle);
    double farthest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double known = std::max({nearest[i].distance, nearest[j].distance, found.distance});
      farthest = std::max(farthest, known + reach_of({corners[i], corners[j], center}));
    }
    return std::min({bound, bound_by(corners, *found.triangle), farthest});
  }

  [[nodiscard]] Piece piece_of(const TriangleMesh& mesh, std::uint32_t triangle) const {
    const TriangleIndices& t = mesh.triangles[triangle];
    return {.corners = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]},
            .nearest = {nearest_[t[0]], nearest_[t[1]], nearest_[t[2]]},
            .triangle = triangle};
  }

  void find_bounds(const TriangleMesh& mesh) {
    nearest_ = nearest_of(mesh.vertices, other_, search_.stop);
    for (std::size_t i = 0; i < nearest_.size(); ++i) {
      record(mesh.vertices[i], nearest_[i].distance);
    }
    bounds_.resize(mesh.triangles.size());
    const auto find_bound = [&](std::size_t i) {
      const Piece piece = piece_of(mesh, static_cast<std::uint32_t>(i));
      bounds_[i] = tightened(bound_of(piece.corners, piece.nearest), piece.corners, piece.nearest);
    };
    in_parallel(bounds_.size(), find_bound, search_.stop);
  }

  // Returns the triangles whose interior may be farther than all vertices; largest bounds first.
  [[nodiscard]] std::vector<std::uint32_t> undecided_triangles() const {
    std::vector<std::uint32_t> undecided;
    for (std::uint32_t i = 0; i < bounds_.size(); ++i) {
      if (is_undecided(bounds_[i])) undecided.push_back(i);
    }
    std::stable_sort(undecided.begin(), undecided.end(),
                     [&](std::uint32_t i, std::uint32_t j) { return bounds_[i] > bounds_[j]; });
    return undecided;
  }

  void keep_undecided(std::vector<Piece>& pieces) {
    std::erase_if(pieces, [&](const Piece& piece) {
      if (is_undecided(piece.bound)) return false;
      leave(piece);
      return true;
    });
    if (pieces.size() <= search_.max_pieces) return;
    // Drops those with the smallest bounds.
    std::stable_sort(pieces.begin(), pieces.end(),
                     [](const Piece& a, const Piece& b) { return a.bound > b.bound; });
    const auto dropped = pieces.begin() + static_cast<std::ptrdiff_t>(search_.max_pieces);
    std::for_each(dropped, pieces.end(), [&](const Piece& piece) { leave(piece); });
    result_.undecided += pieces.size() - search_.max_pieces;
    pieces.erase(dropped, pieces.end());
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
        parts[4 * i + part].triangle = pieces[i].triangle;
        const double bound = bound_of(four[part].corners, four[part].nearest);
        parts[4 * i + part].bound =
            tightened(std::min(pieces[i].bound, bound), four[part].corners, four[part].nearest);
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
  bool decides_limit_ = false;  // Searches only for points beyond the limit.
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
      return one_sided(part, triangles_of(part), NearestTriangle(triangles_of(other), search.stop),
                       search);
    };
    return {.mesh_to_reference = part_from(mesh, reference),
            .reference_to_mesh = part_from(reference, mesh)};
  }
  const std::vector<SurfaceTriangle> of_mesh = triangles_of(mesh);
  const std::vector<SurfaceTriangle> of_reference = triangles_of(reference);
  TwoSidedDistance result;
  result.mesh_to_reference =
      one_sided(mesh, of_mesh, NearestTriangle(of_reference, search.stop), search);
  result.reference_to_mesh =
      one_sided(reference, of_reference, NearestTriangle(of_mesh, search.stop), search);
  return result;
}

}  // namespace multitetra

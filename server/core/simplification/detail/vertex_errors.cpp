#include "server/core/simplification/detail/vertex_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace multitetra {

bool VertexErrors::fits(std::uint32_t u, std::span<const std::uint32_t> ring,
                        std::span<const Vec3> ring_positions, double limit) {
  ring_ = ring;
  before_.clear();
  for (const std::uint32_t w : ring) {
    if (errors_[w] > limit) return false;
    before_.push_back(errors_[w]);
  }
  const double error = errors_[u];
  const double moved = length(difference(positions_[u], ring_positions[0])) + error;
  const bool fits_map = fits_as_map(positions_[u], error, ring_positions, limit);
  if (moved <= limit && (!fits_map || moved <= raised_)) {
    after_ = before_;
    after_[0] = std::max(after_[0], moved);
    return true;
  }
  return fits_map;
}

void VertexErrors::commit() {
  for (std::size_t i = 0; i < ring_.size(); ++i) errors_[ring_[i]] = after_[i];
}

VertexErrors::Place VertexErrors::nearest(const Vec3& point, std::span<const Vec3> ring) {
  const auto last = static_cast<std::uint32_t>(ring.size()) - 1;
  Place place{.squared_distance = std::numeric_limits<double>::infinity()};
  const Vec3 p = difference(point, ring[0]);
  // Projections onto triangles.
  for (std::uint32_t k = 1; k < last; ++k) {
    const Vec3 a = difference(ring[k], ring[0]);
    const Vec3 b = difference(ring[k + 1], ring[0]);
    const Vec3 normal = cross(a, b);
    const double squared = squared_length(normal);
    if (!(squared > 0)) continue;
    const double first = dot(cross(p, b), normal) / squared;
    const double second = dot(cross(a, p), normal) / squared;
    if (!(first >= 0 && second >= 0 && first + second <= 1)) continue;
    const double height = dot(p, normal);
    const double distance = height * height / squared;
    if (distance < place.squared_distance) {
      place = {k, 1 - first - second, first, second, distance};
    }
  }
  if (place.squared_distance < std::numeric_limits<double>::infinity()) return place;
  const auto share = [](const Vec3& from, const Vec3& along) {
    const double squared = squared_length(along);
    return squared > 0 ? std::clamp(dot(from, along) / squared, 0.0, 1.0) : 0.0;
  };
  for (std::uint32_t k = 1; k <= last; ++k) {
    const Vec3 spoke = difference(ring[k], ring[0]);
    const double t = share(p, spoke);
    const double distance = squared_length(moved(p, -t, spoke));
    if (distance < place.squared_distance) {
      const std::uint32_t sector = std::min(k, last - 1);
      place = {sector, 1 - t, k == sector ? t : 0, k == sector ? 0 : t, distance};
    }
  }
  for (std::uint32_t k = 1; k < last; ++k) {
    const Vec3 rim = difference(ring[k + 1], ring[k]);
    const Vec3 from = difference(point, ring[k]);
    const double t = share(from, rim);
    const double distance = squared_length(moved(from, -t, rim));
    if (distance < place.squared_distance) place = {k, 0, 1 - t, t, distance};
  }
  return place;
}

// Finds the level l with sum w_i max(e_i, l) = least, from above, successively excluding higher
// errors. Rounding loses far less than StoredMapping::kRounding adds.
void VertexErrors::raise(std::span<const Weighted> corners, double least) {
  double mean = 0;
  for (const auto& [i, weight] : corners) mean += weight * after_[i];
  if (mean >= least) return;
  double level = least;
  for (std::size_t round = 1; round < corners.size(); ++round) {
    double weights = 0;
    double missing = least;
    for (const auto& [i, weight] : corners) {
      if (after_[i] < level) {
        weights += weight;
      } else {
        missing -= weight * after_[i];
      }
    }
    if (!(weights > 1e-6)) break;
    level = std::min(level, missing / weights);
  }
  for (const auto& [i, weight] : corners) {
    if (weight > 0) after_[i] = std::max(after_[i], level);
  }
  raised_ = std::max(raised_, level);
}

bool VertexErrors::fits_as_map(const Vec3& point, double error,
                               std::span<const Vec3> ring_positions, double limit) {
  after_ = before_;
  raised_ = 0;
  const Place place = nearest(point, ring_positions);
  raise(
      std::array<Weighted, 3>{
          {{0, place.at_v}, {place.sector, place.at_first}, {place.sector + 1, place.at_second}}},
      error + std::sqrt(place.squared_distance));
  if (!(raised_ <= limit)) return false;
  const Vec3 p = difference(point, ring_positions[0]);
  for (std::uint32_t k = 1; k < ring_positions.size(); ++k) {
    std::uint32_t first = place.sector + 1;
    std::uint32_t last = k - 1;
    if (k < place.sector) {
      first = k + 1;
      last = place.sector;
    }
    if (k >= place.sector && k <= place.sector + 1) continue;
    const Vec3 edge = difference(ring_positions[k], point);
    const double squared_edge = squared_length(edge);
    const double edge_p = dot(edge, p);
    for (std::uint32_t j = first; j <= last; ++j) {
      const Vec3 spoke = difference(ring_positions[j], ring_positions[0]);
      const double squared_spoke = squared_length(spoke);
      const double mixed = dot(edge, spoke);
      const double spoke_p = dot(spoke, p);
      const double determinant = squared_edge * squared_spoke - mixed * mixed;
      double s = 0;
      if (determinant > 1e-12 * squared_edge * squared_spoke) {
        s = std::clamp((mixed * spoke_p - edge_p * squared_spoke) / determinant, 0.0, 1.0);
      }
      const double t_of_line = squared_spoke > 0 ? (spoke_p + s * mixed) / squared_spoke : 0;
      const double t = std::clamp(t_of_line, 0.0, 1.0);
      if (t != t_of_line && squared_edge > 0) {
        s = std::clamp((t * mixed - edge_p) / squared_edge, 0.0, 1.0);
      }
      const double distance = length(moved(moved(p, s, edge), -t, spoke));
      raise(std::array<Weighted, 2>{{{0, 1 - t}, {j, t}}},
            (1 - s) * error + s * before_[k] + distance);
      if (!(raised_ <= limit)) return false;
    }
  }
  return true;
}

}  // namespace multitetra

#include "server/core/simplification/detail/collapse_fan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/vec3.hpp"

namespace multitetra {

void CollapseFan::set_up(std::span<const Vec3> ring, double limit) {
  sectors_ = static_cast<std::uint32_t>(ring.size()) - 2;
  apex_ = ring[0];
  limit_ = limit;
  largest_ = 0;
  spokes_.resize(ring.size());
  triangles_.resize(ring.size() - 1);
  for (std::uint32_t k = 1; k < ring.size(); ++k) {
    FanEdge& spoke = spokes_[k];
    spoke.along = difference(ring[k], apex_);
    spoke.squared_length = squared_length(spoke.along);
    spoke.inverse = spoke.squared_length > 0 ? 1 / spoke.squared_length : 0;
  }
  for (std::uint32_t k = 1; k <= sectors_; ++k) {
    const Vec3& a = spokes_[k].along;
    const Vec3& b = spokes_[k + 1].along;
    Triangle& t = triangles_[k];
    t.normal = cross(a, b);
    const double squared = squared_length(t.normal);
    const bool is_thin =
        squared <= kMinSquaredSine * spokes_[k].squared_length * spokes_[k + 1].squared_length;
    t.inverse = is_thin ? 0 : 1 / squared;
    t.first = moved({0, 0, 0}, t.inverse, cross(b, t.normal));
    t.second = moved({0, 0, 0}, t.inverse, cross(t.normal, a));
  }
}

std::optional<std::uint32_t> CollapseFan::sector_near(const Point& point) {
  const double allowed = limit_ - point.error;
  if (!(allowed >= 0)) return std::nullopt;
  const double squared_limit = allowed * allowed;
  const Vec3 p = difference(point.at, apex_);
  double nearest = std::numeric_limits<double>::infinity();
  std::uint32_t sector = 1;
  for (std::uint32_t k = 1; k <= sectors_; ++k) {
    const Triangle& t = triangles_[k];
    const double s = dot(p, t.first);
    const double r = dot(p, t.second);
    if (!(s >= 0 && r >= 0 && s + r <= 1) || t.inverse == 0) continue;
    const double height = dot(p, t.normal);
    const double squared = height * height * t.inverse;
    if (squared < nearest) {
      nearest = squared;
      sector = k;
    }
  }
  if (!(nearest <= squared_limit)) {
    const auto look_at = [&](const Vec3& to, std::uint32_t k) {
      const double squared = squared_length(to);
      if (squared < nearest) {
        nearest = squared;
        sector = k;
      }
    };
    for (std::uint32_t k = 1; k <= sectors_ + 1; ++k) {
      const FanEdge& spoke = spokes_[k];
      const double t = std::clamp(dot(p, spoke.along) * spoke.inverse, 0.0, 1.0);
      look_at(moved(p, -t, spoke.along), std::min(k, sectors_));
    }
    for (std::uint32_t k = 1; k <= sectors_; ++k) {
      const Vec3 edge = difference(spokes_[k + 1].along, spokes_[k].along);
      const Vec3 from = difference(p, spokes_[k].along);
      const double t = std::clamp(dot(from, edge) / squared_length(edge), 0.0, 1.0);
      look_at(moved(from, -t, edge), k);
    }
    if (!(nearest <= squared_limit)) return std::nullopt;
  }
  largest_ = std::max(largest_, std::sqrt(nearest) + point.error);
  return sector;
}

CollapseFan::RelativeEdge::RelativeEdge(const Point& low_end, const Point& high_end,
                                        const Vec3& from)
    : low(difference(low_end.at, from)),
      along(difference(high_end.at, low_end.at)),
      squared_length(multitetra::squared_length(along)),
      low_along(dot(low, along)),
      error(low_end.error),
      rise(high_end.error - low_end.error) {}

// Measures at the pair of nearest points. It is the same pair seen from either side of an edge, as
// limits that vary between triangles require.
bool CollapseFan::is_near(const RelativeEdge& edge, const FanEdge& spoke) {
  const double mixed = dot(edge.along, spoke.along);
  const double along_spoke = dot(edge.low, spoke.along);
  const double product = edge.squared_length * spoke.squared_length;
  const double determinant = product - mixed * mixed;
  double s = 0;
  if (determinant > 1e-12 * product) {
    s = std::clamp((mixed * along_spoke - edge.low_along * spoke.squared_length) / determinant, 0.0,
                   1.0);
  }
  const double t_of_line = (along_spoke + s * mixed) * spoke.inverse;
  const double t = std::clamp(t_of_line, 0.0, 1.0);
  if (t != t_of_line) {
    s = std::clamp((t * mixed - edge.low_along) / edge.squared_length, 0.0, 1.0);
  }
  const Vec3 between = moved(moved(edge.low, -t, spoke.along), s, edge.along);
  const double distance = std::sqrt(squared_length(between)) + edge.error + s * edge.rise;
  if (!(distance <= limit_)) return false;
  largest_ = std::max(largest_, distance);
  return true;
}

bool CollapseFan::is_near(const Point& low, const Point& high, std::uint32_t first,
                          std::uint32_t last) {
  const RelativeEdge edge(low, high, apex_);
  for (std::uint32_t k = first; k <= last; ++k) {
    if (!is_near(edge, spokes_[k])) return false;
  }
  return true;
}

bool CollapseFan::is_near_rim(const Point& low, const Point& high, const Vec3& begin,
                              const Vec3& end) {
  FanEdge rim{.along = difference(end, begin)};
  rim.squared_length = squared_length(rim.along);
  rim.inverse = rim.squared_length > 0 ? 1 / rim.squared_length : 0;
  return is_near(RelativeEdge(low, high, begin), rim);
}

bool CollapseFan::is_near(double error) {
  if (!(error <= limit_)) return false;
  largest_ = std::max(largest_, error);
  return true;
}

}  // namespace multitetra

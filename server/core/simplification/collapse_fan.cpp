#include "server/core/simplification/collapse_fan.hpp"

#include <algorithm>
#include <limits>

#include "common/base/vec3.hpp"

namespace multitetra {

void CollapseFan::set_up(std::span<const Vec3> ring, double squared_limit) {
  sectors_ = static_cast<std::uint32_t>(ring.size()) - 2;
  apex_ = ring[0];
  squared_limit_ = squared_limit;
  largest_ = 0;
  spokes_.resize(ring.size());
  triangles_.resize(ring.size() - 1);
  for (std::uint32_t k = 1; k < ring.size(); ++k) {
    Spoke& spoke = spokes_[k];
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
        squared <= kThinnest * spokes_[k].squared_length * spokes_[k + 1].squared_length;
    t.inverse = is_thin ? 0 : 1 / squared;
    t.first = moved({0, 0, 0}, t.inverse, cross(b, t.normal));
    t.second = moved({0, 0, 0}, t.inverse, cross(t.normal, a));
  }
}

std::optional<std::uint32_t> CollapseFan::sector_near(const Vec3& point) {
  const Vec3 p = difference(point, apex_);
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
  if (!(nearest <= squared_limit_)) {
    const auto look_at = [&](const Vec3& to, std::uint32_t k) {
      const double squared = squared_length(to);
      if (squared < nearest) {
        nearest = squared;
        sector = k;
      }
    };
    for (std::uint32_t k = 1; k <= sectors_ + 1; ++k) {
      const Spoke& spoke = spokes_[k];
      const double t = std::clamp(dot(p, spoke.along) * spoke.inverse, 0.0, 1.0);
      look_at(moved(p, -t, spoke.along), std::min(k, sectors_));
    }
    for (std::uint32_t k = 1; k <= sectors_; ++k) {
      const Vec3 edge = difference(spokes_[k + 1].along, spokes_[k].along);
      const Vec3 from = difference(p, spokes_[k].along);
      const double t = std::clamp(dot(from, edge) / squared_length(edge), 0.0, 1.0);
      look_at(moved(from, -t, edge), k);
    }
    if (!(nearest <= squared_limit_)) return std::nullopt;
  }
  largest_ = std::max(largest_, nearest);
  return sector;
}

// A pair of near points is enough, whichever it is.
bool CollapseFan::is_near(const Vec3& low, const Vec3& high, std::uint32_t first,
                          std::uint32_t last) {
  const Vec3 p = difference(low, apex_);
  const Vec3 pq = difference(high, low);
  const double squared_pq = squared_length(pq);
  const double along_pq = dot(p, pq);
  for (std::uint32_t k = first; k <= last; ++k) {
    const Spoke& spoke = spokes_[k];
    const double mixed = dot(pq, spoke.along);
    const double along_spoke = dot(p, spoke.along);
    const double product = squared_pq * spoke.squared_length;
    const double determinant = product - mixed * mixed;
    double s = 0;
    if (determinant > 1e-12 * product) {
      s = std::clamp((mixed * along_spoke - along_pq * spoke.squared_length) / determinant, 0.0,
                     1.0);
    }
    const double t = std::clamp((along_spoke + s * mixed) * spoke.inverse, 0.0, 1.0);
    const Vec3 from = moved(p, -t, spoke.along);
    double squared = squared_length(moved(from, s, pq));
    if (!(squared <= squared_limit_)) {
      s = std::clamp((t * mixed - along_pq) / squared_pq, 0.0, 1.0);
      squared = squared_length(moved(from, s, pq));
      if (!(squared <= squared_limit_)) return false;
    }
    largest_ = std::max(largest_, squared);
  }
  return true;
}

}  // namespace multitetra

// Dividing points: where the framework bisects tetrahedra (Zhou, Chen and Kaufman 1997, section 3).
//
// Every grid point except the grid's eight corners divides the tetrahedra that share an edge AB,
// its *split edge*, at the midpoint of AB. Its coordinates determine its kind: its spacing s is the
// largest power of two that divides them all; count the odd numbers among x/s, y/s, z/s.
//
//   odd   kind   dividing point of             split edge        tetrahedra   in the paper
//   2     face   a square face of side 2s      its diagonal      4            case 1, step 1
//   1     edge   an axis-parallel edge, 2s     the edge          8            case 2, step 2
//   3     cube   a cube of side 2s             its diagonal      6            case 3, step 3
//
// The tetrahedra around AB form the point's *diamond*. Their other corners form its *link*, a
// closed ring around AB (open at the grid's border). All are in the 3 x 3 x 3 points of step s.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>

#include "server/core/framework/grid.hpp"

namespace multitetra {

enum class PointKind : std::uint8_t { kEdge, kFace, kCube };

// A list of grid points with a fixed capacity; does not allocate.
template <std::size_t Capacity>
class PointList {
 public:
  constexpr void push_back(GridPoint p) { points_[size_++] = p; }
  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr const GridPoint* begin() const { return points_.data(); }
  [[nodiscard]] constexpr const GridPoint* end() const { return points_.data() + size_; }
  [[nodiscard]] constexpr GridPoint operator[](std::size_t i) const { return points_[i]; }

 private:
  std::array<GridPoint, Capacity> points_{};
  std::size_t size_ = 0;
};

class DividingPoint {
 public:
  struct SplitEdge {
    GridPoint a;
    GridPoint b;
  };

  // Requires a grid point that is not one of the grid's eight corners.
  explicit constexpr DividingPoint(GridPoint at) : at_(at), spacing_(spacing_of(at)) {
    const int odd = (is_odd(0) ? 1 : 0) + (is_odd(1) ? 1 : 0) + (is_odd(2) ? 1 : 0);
    kind_ = odd == 1 ? PointKind::kEdge : odd == 2 ? PointKind::kFace : PointKind::kCube;
  }

  [[nodiscard]] constexpr GridPoint at() const { return at_; }
  [[nodiscard]] constexpr std::int32_t spacing() const { return spacing_; }
  [[nodiscard]] constexpr PointKind kind() const { return kind_; }

  // Returns the depth of the tetrahedra that the point divides: 0 for the twelve of the root cube.
  // The grid's center, which creates those, has depth -1.
  [[nodiscard]] constexpr int depth(const Grid& grid) const {
    int level = 0;
    for (std::int32_t s = grid.side() / 2; s > spacing_; s /= 2) ++level;
    return 3 * level + (kind_ == PointKind::kFace ? 0 : kind_ == PointKind::kEdge ? 1 : -1);
  }

  [[nodiscard]] constexpr SplitEdge split_edge() const;

  // Returns the link, cyclic around the split edge: 4, 8 or 6 points, some perhaps outside the
  // grid.
  [[nodiscard]] constexpr PointList<8> ring() const;

  // Returns the points whose insertion creates the tetrahedra that this point divides; a point may
  // be kept only if all its parents are. At most 4, inside the grid; its center has none.
  [[nodiscard]] constexpr PointList<4> parents(const Grid& grid) const;

  // Returns the points inside the grid that have this one as a parent: up to 8 for an edge, 4 for a
  // face, 6 for a cube.
  [[nodiscard]] constexpr PointList<8> children(const Grid& grid) const;

 private:
  // Returns whether the coordinate is odd in units of the spacing.
  [[nodiscard]] constexpr bool is_odd(int axis) const { return (at_[axis] & spacing_) != 0; }
  // Returns whether the coordinate of at_ + sign * spacing is odd in units of twice the spacing.
  [[nodiscard]] constexpr bool is_odd_end(int axis, int sign) const {
    return ((at_[axis] + sign * spacing_) & (2 * spacing_)) != 0;
  }
  [[nodiscard]] constexpr int only_axis(bool odd) const {
    return is_odd(0) == odd ? 0 : is_odd(1) == odd ? 1 : 2;
  }
  // Returns the offset to the end with odd coordinates (in units of twice the spacing): +-spacing
  // along every odd axis.
  [[nodiscard]] constexpr GridPoint to_odd_end() const {
    const auto step = [this](int axis) {
      return !is_odd(axis) ? 0 : is_odd_end(axis, 1) ? spacing_ : -spacing_;
    };
    return {step(0), step(1), step(2)};
  }

  GridPoint at_;
  std::int32_t spacing_;
  PointKind kind_;
};

constexpr DividingPoint::SplitEdge DividingPoint::split_edge() const {
  // Face and cube: the diagonal with ends all even and all odd in units of 2s. Edge: its ends.
  const GridPoint offset = to_odd_end();
  return {at_ - offset, at_ + offset};
}

constexpr PointList<8> DividingPoint::ring() const {
  PointList<8> ring;
  switch (kind_) {
    case PointKind::kFace: {
      const int normal = only_axis(false);
      const GridPoint up = spacing_ * unit(normal);
      const GridPoint diagonal = to_odd_end();
      // The face's other diagonal: one in-face component reversed.
      const int turned = (normal + 1) % 3;
      const GridPoint across = diagonal - 2 * (diagonal[turned] * unit(turned));
      for (const GridPoint offset : {across, up, -1 * across, -1 * up})
        ring.push_back(at_ + offset);
      break;
    }
    case PointKind::kEdge: {
      const int axis = only_axis(true);
      const GridPoint u = spacing_ * unit((axis + 1) % 3);
      const GridPoint v = spacing_ * unit((axis + 2) % 3);
      for (const GridPoint offset : {u, u + v, v, v - u, -1 * u, -1 * u - v, -1 * v, u - v}) {
        ring.push_back(at_ + offset);
      }
      break;
    }
    case PointKind::kCube: {
      // From the end B = at + (x, y, z) to A = at - (x, y, z), the six other corners alternate
      // between those that differ from B along one axis and along two axes.
      const GridPoint b = to_odd_end();
      const GridPoint x = 2 * (b.x * unit(0));
      const GridPoint y = 2 * (b.y * unit(1));
      const GridPoint z = 2 * (b.z * unit(2));
      for (const GridPoint turned : {x, x + y, y, y + z, z, z + x})
        ring.push_back(at_ + b - turned);
      break;
    }
  }
  return ring;
}

constexpr PointList<4> DividingPoint::parents(const Grid& grid) const {
  PointList<4> parents;
  const auto add = [&](GridPoint p) {
    if (grid.contains(p)) parents.push_back(p);
  };
  switch (kind_) {
    case PointKind::kFace: {  // The centers of the two cubes that share the face.
      const GridPoint up = spacing_ * unit(only_axis(false));
      add(at_ + up);
      add(at_ - up);
      break;
    }
    case PointKind::kEdge:  // The centers of the four faces around the edge.
      for (int axis = 0; axis < 3; ++axis) {
        if (is_odd(axis)) continue;
        add(at_ + spacing_ * unit(axis));
        add(at_ - spacing_ * unit(axis));
      }
      break;
    case PointKind::kCube: {  // The three corners that are edge points of twice the spacing.
      if (2 * spacing_ == grid.side()) break;
      const GridPoint b = to_odd_end();
      for (int axis = 0; axis < 3; ++axis) {
        add(at_ - b + 2 * (b[axis] * unit(axis)));
      }
      break;
    }
  }
  return parents;
}

constexpr PointList<8> DividingPoint::children(const Grid& grid) const {
  PointList<8> children;
  const auto add = [&](GridPoint p) {
    if (grid.contains(p)) children.push_back(p);
  };
  switch (kind_) {
    case PointKind::kCube:  // The centers of the cube's six faces.
      for (int axis = 0; axis < 3; ++axis) {
        add(at_ + spacing_ * unit(axis));
        add(at_ - spacing_ * unit(axis));
      }
      break;
    case PointKind::kFace:  // The midpoints of the face's four edges.
      for (int axis = 0; axis < 3; ++axis) {
        if (!is_odd(axis)) continue;
        add(at_ + spacing_ * unit(axis));
        add(at_ - spacing_ * unit(axis));
      }
      break;
    case PointKind::kEdge: {  // The centers of the eight cubes of half the size around the point.
      const std::int32_t half = spacing_ / 2;
      if (half == 0) break;
      for (int octant = 0; octant < 8; ++octant) {
        add(at_ + GridPoint{(octant & 1) != 0 ? half : -half, (octant & 2) != 0 ? half : -half,
                            (octant & 4) != 0 ? half : -half});
      }
      break;
    }
  }
  return children;
}

}  // namespace multitetra

// The error curves of the dividing points of one spacing, computed layer by layer along z.
//
// A level of spacing s = 2^e uses units of s. Its points lie in even layers (edge midpoints and
// face centers) and in odd layers (edge midpoints, face centers, cube centers). Step k computes
//
//   even layer 2k + 2     edges, then faces          2k + 2   e   f   e   f
//   odd layer 2k + 1      edges, faces, then cubes   2k + 1   f   c   f   c     from the layers
//   (even layer 2k is kept from the last step)       2k       e   f   e   f     2k - 1 ... 2k + 3
//
// of samples and the cubes of the finer level in its steps 2k - 1 ... 2k + 2. So a level holds only
// a few layers, for any extent of the volume along z.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "server/core/framework/grid.hpp"
#include "server/core/framework/grid_step_lengths.hpp"
#include "server/core/spectrum/detail/error_curve.hpp"
#include "server/core/spectrum/detail/own_error_curve.hpp"
#include "server/core/spectrum/detail/own_error_rows.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"

namespace multitetra {

// The source of a level's field values.
class PlaneSource {
 public:
  virtual ~PlaneSource() = default;
  // Reads the values at the points 2^exponent (low + (x, y, 0)), 0 <= x, y < extent, x fastest; NaN
  // is void. Requires grid points.
  virtual void read(int exponent, GridPoint low, GridPoint extent, float* into) const = 0;
};

// The finer level's cube centers around one of this level, by their steps 2k - 1 ... 2k + 2.
class FinerCubes {
 public:
  // Adds those of step k, at (x / 2, y / 2) rounded down. The layer must outlive this object.
  void add(std::int32_t k, const CurveLayer& cubes) {
    layers_[static_cast<std::size_t>(k) % layers_.size()] = &cubes;
  }
  // Returns null without curves. Requires one of the four steps, or a negative one.
  [[nodiscard]] const CurveLayer* layer(std::int32_t k) const {
    return k < 0 ? nullptr : layers_[static_cast<std::size_t>(k) % layers_.size()];
  }

 private:
  std::array<const CurveLayer*, 4> layers_{};
};

// The points that a level computes, in its units. Points outside have no errors or are not needed.
struct LevelWindow {
  int exponent = 0;
  GridPoint low;  // z is even.
  GridPoint extent;

  [[nodiscard]] std::int32_t first_step() const { return low.z / 2; }
  [[nodiscard]] std::int32_t end_step() const { return (low.z + extent.z) / 2; }
};

template <typename Real>
class LevelWavefront {
 public:
  // The bins must outlive the level.
  LevelWavefront(const Grid& grid, const Vec3& spacing, const IsovalueBins& bins,
                 const LevelWindow& window);

  // Loads the values of the next layer, z = next_plane() in units. It must be at most 4 layers
  // ahead of those that the next step needs.
  void load_plane(const PlaneSource& values);
  [[nodiscard]] std::int32_t next_plane() const { return loaded_ + 1; }

  // Computes step k = next_step(). Requires has_values() and not is_done().
  void step(const FinerCubes& finer);
  [[nodiscard]] bool has_values() const {
    return loaded_ >= std::min(2 * next_ + 3, grid_.side() >> window_.exponent);
  }
  [[nodiscard]] const LevelWindow& window() const { return window_; }
  [[nodiscard]] std::int32_t next_step() const { return next_; }
  [[nodiscard]] bool is_done() const { return next_ >= window_.end_step(); }

  // Return layers 2k, 2k + 1 and 2k + 2 of the last step.
  [[nodiscard]] const CurveLayer& lower() const { return even_[lower_]; }
  [[nodiscard]] const CurveLayer& middle() const { return odd_; }
  [[nodiscard]] const CurveLayer& upper() const { return even_[1 - lower_]; }
  // Copies the cube centers of the middle layer to (x / 2, y / 2), rounded down.
  void copy_cubes(CurveLayer& into) const;

 private:
  void fill_even(std::int32_t z, CurveLayer& layer, const FinerCubes& finer);
  void fill_odd(std::int32_t z, const FinerCubes& finer);
  void make_offsets(std::int32_t z);
  [[nodiscard]] const float* plane(std::int32_t z) const {
    return planes_.data() + (z & 7) * plane_size_;
  }
  struct Child {
    CurveLayer::Curve curve;
    const CurveLayer* layer = nullptr;
  };
  struct Children {
    std::array<Child, 8> of;
    std::size_t count = 0;
    void add(Child child) {
      if (child.curve.count > 0) of[count++] = child;
    }
  };
  using Bins = typename OwnErrorCurve<Real>::Bins;
  // A new curve of one point that covers these bins and its children's, with the children's errors.
  struct Appended {
    CurveBlock* blocks = nullptr;  // Null without a curve.
    int first_bin = 0;
  };
  Appended append(GridPoint unit_point, CurveLayer& layer, const Children& children, bool is_mixed,
                  Bins active) const;
  [[nodiscard]] Bins bins_between(Real low, Real high) const;
  void fill(GridPoint unit_point, CurveLayer& layer, const Children& children) const;
  void fill(GridPoint unit_point, CurveLayer& layer, const Children& children,
            const FourOwnErrors& errors, std::size_t lane) const;
  void add_own(const DiamondValues<Real>& values, Bins active, bool any_void,
               const Appended& curve) const;
  [[nodiscard]] bool compute_errors(GridPoint first, std::size_t count);
  void load(GridPoint unit_point, DiamondValues<Real>& diamond) const;
  template <typename AddChildren>
  void fill_points(std::int32_t z, bool odd_x, bool odd_y, CurveLayer& layer,
                   const AddChildren& add_children);
  [[nodiscard]] Children finer_cubes(GridPoint p, const FinerCubes& finer) const;

  Grid grid_;
  const IsovalueBins& bins_;
  LevelWindow window_;
  DiamondLengths<Real> lengths_;
  GridPoint plane_low_;  // In units: the window and a border of one unit, clipped to the grid.
  GridPoint plane_extent_;
  std::ptrdiff_t plane_size_ = 0;
  std::vector<float> planes_;  // A ring of eight: layer z has index z & 7.
  std::int32_t loaded_ = -1;   // The last loaded layer of values.
  // By shape: offsets of the corners from a point of the current layer; 0 after the last one.
  std::array<std::array<std::ptrdiff_t, 12>, 64> offsets_{};
  std::vector<FourOwnErrors> errors_;  // The errors of the current row.
  std::array<CurveLayer, 2> even_;
  // even_[lower_] is layer 2k, the other 2k + 2.
  std::size_t lower_ = 1;
  std::int32_t next_ = 0;
  CurveLayer odd_;
};

extern template class LevelWavefront<float>;
extern template class LevelWavefront<double>;

}  // namespace multitetra

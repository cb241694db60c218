// The three-dimensional Shepp-Logan head phantom, in Hounsfield units.
//
// Ten ellipsoids in the cube [-1, 1]^3 whose values add up. Shapes and positions: A. C. Kak and M.
// Slaney, "Principles of Computerized Tomographic Imaging", IEEE Press 1988, chapter 3 (after L. A.
// Shepp and B. F. Logan, "The Fourier Reconstruction of a Head Section", IEEE Transactions on
// Nuclear Science 21, 1974); the same table is the variant "yu-ye-wang" of M. Schabel's phantom3d.
// The published contrasts of one or two percent are stretched so that a few isovalues separate the
// tissues: air -1000, ventricles 0, brain 200, tumors 300, skull 1000.
//
// As in a scanner, a sample is the mean over its voxel: across a surface the value changes linearly
// over one voxel, so the isosurface halfway coincides with the ellipsoid.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace multitetra {

class HeadPhantom {
 public:
  // Samples fill a cube of `size` samples per side, at least 2.
  explicit HeadPhantom(std::int32_t size);

  // Computes the samples of a row along x.
  void fill_row(std::int32_t y, std::int32_t z, std::span<double> row) const;

 private:
  struct Ellipsoid {
    double value;
    std::array<double, 3> inverse_axes;  // 1 / semi-axis.
    std::array<double, 3> center;
    // Cosine and sine of its rotation about z.
    double cosine;
    double sine;
    // Half extents of its bounding box, plus one voxel.
    std::array<double, 3> half_extents;
  };

  void add(const Ellipsoid& ellipsoid, double y, double z, std::span<double> row) const;

  double size_;
  double voxel_;  // Distance between samples.
  std::array<Ellipsoid, 10> ellipsoids_;
};

}  // namespace multitetra

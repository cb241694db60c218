// The samples of a uniform level in an octree cube, as a sample shell holds them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <variant>
#include <vector>

#include "common/codec/shell_encoder.hpp"
#include "common/mesh/octree_cube.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {

// The part of a cube with samples of the data, and the layers around it where the surface closes.
struct LevelBox {
  GridPoint first;           // The data's first sample in the cube, in spacings.
  GridPoint count;           // Samples of the data along each axis, at least 1.
  std::uint32_t layers = 0;  // As in ShellBox.

  // In spacings, layers included.
  [[nodiscard]] GridPoint origin() const {
    const auto low = [this](int axis) {
      return static_cast<std::int32_t>(layers >> (2 * axis) & 1U);
    };
    return first - GridPoint{low(0), low(1), low(2)};
  }
};

// Nothing where no cell of the level in the cube has a value at each corner. `spacing` is at most
// the cube's side.
[[nodiscard]] std::optional<LevelBox> level_box(const DatasetInfo& info, const OctreeCube& cube,
                                                std::int32_t spacing);

using SampleArray =
    std::variant<std::vector<std::uint8_t>, std::vector<std::int8_t>, std::vector<std::uint16_t>,
                 std::vector<std::int16_t>, std::vector<float>>;

// For surfaces of one isovalue at one level. The volume must outlive it. Safe to use from several
// threads at once. Throws what reading samples throws.
class LevelSamples {
 public:
  LevelSamples(const PreparedVolume& volume, double isovalue, std::int32_t spacing)
      : volume_(volume), isovalue_(isovalue), spacing_(spacing) {}

  // Whether there can be a surface in the cube, as far as can be seen without the samples.
  [[nodiscard]] bool may_be_crossed(const OctreeCube& cube) const;

  // The samples of the box in the cube, x fastest, in the dataset's type. Where no edge of the
  // level in the cube is crossed, a brick is not read: its samples have any value on the right
  // side.
  void read(const OctreeCube& cube, const LevelBox& box, SampleArray& into) const;

  // The bricks that read() looks at, of a level that has any.
  void add_bricks(const OctreeCube& cube, const LevelBox& box,
                  std::vector<std::size_t>& bricks) const;

 private:
  // The samples of the level in one brick, as a part of the box.
  struct BrickPart {
    GridCounts brick{};
    GridPoint first;  // In spacings.
    GridPoint last;
    bool is_needed = true;
  };
  void visit_bricks(const OctreeCube& cube, const LevelBox& box,
                    const std::function<void(const BrickPart&)>& visit) const;
  template <typename Sample>
  void read_bricks(const OctreeCube& cube, const LevelBox& box, std::vector<Sample>& into) const;
  template <typename Sample>
  void read_coarse(const LevelBox& box, std::vector<Sample>& into) const;
  // Any sample of the closed cell of kSpectrumSpacing steps in `cube` that holds this point.
  template <typename Sample>
  [[nodiscard]] Sample sample_near(const OctreeCube& cube, GridPoint point) const;

  const PreparedVolume& volume_;
  double isovalue_;
  std::int32_t spacing_;
};

}  // namespace multitetra

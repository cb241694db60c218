// The samples of a uniform level in an octree cube, in the layout of a sample shell.
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

// The part of a cube with samples of the data, and the layers around it that close the surface.
struct LevelBox {
  GridPoint first;           // The data's first sample in the cube, in spacings.
  GridPoint count;           // Samples of the data along each axis, at least 1.
  std::uint32_t layers = 0;  // See ShellBox.

  // The data's last sample in the cube, in spacings.
  [[nodiscard]] GridPoint last() const { return first + count - GridPoint{1, 1, 1}; }
  // In spacings, including the layers.
  [[nodiscard]] GridPoint origin() const {
    const auto low = [this](int axis) {
      return static_cast<std::int32_t>(layers >> (2 * axis) & 1U);
    };
    return first - GridPoint{low(0), low(1), low(2)};
  }
};

// Returns nullopt if no cell of the level in the cube has values at all corners. `spacing` is at
// most the cube's side.
[[nodiscard]] std::optional<LevelBox> level_box(const DatasetInfo& info, const OctreeCube& cube,
                                                std::int32_t spacing);

using SampleArray =
    std::variant<std::vector<std::uint8_t>, std::vector<std::int8_t>, std::vector<std::uint16_t>,
                 std::vector<std::int16_t>, std::vector<float>>;

// Reads samples for surfaces of one isovalue at one level. The volume must outlive it. Thread-safe.
// Rethrows exceptions from reading samples.
class LevelSamples {
 public:
  LevelSamples(const PreparedVolume& volume, double isovalue, std::int32_t spacing)
      : volume_(volume), isovalue_(isovalue), spacing_(spacing) {}

  // Returns whether the cube may contain a surface, as far as known without reading samples.
  [[nodiscard]] bool may_be_crossed(const OctreeCube& cube) const;

  // Returns the part of the cube's box outside of which nothing is crossed, or the whole box if
  // that requires the samples; nullopt if nothing is crossed.
  [[nodiscard]] std::optional<LevelBox> crossed_part(const OctreeCube& cube,
                                                     const LevelBox& box) const;

  // Reads the samples of the box in the cube, x fastest, in the dataset's type. Skips bricks
  // without crossed edges of the level in the cube: their samples get any value on the same side.
  void read(const OctreeCube& cube, const LevelBox& box, SampleArray& into) const;

  // Appends the bricks that read() needs. Requires a level that is read from bricks.
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
  // Returns some sample of the closed cell of kSpectrumSpacing steps in `cube` with this point.
  template <typename Sample>
  [[nodiscard]] Sample sample_near(const OctreeCube& cube, GridPoint point) const;

  const PreparedVolume& volume_;
  double isovalue_;
  std::int32_t spacing_;
};

}  // namespace multitetra

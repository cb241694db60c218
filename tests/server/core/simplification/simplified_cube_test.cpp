#include "server/core/simplification/simplified_cube.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <numeric>

#include "common/mesh/content_digest.hpp"
#include "server/core/planning/simplified_size.hpp"
#include "server/core/surface/tiling.hpp"
#include "tests/support/simplifying.hpp"

namespace multitetra::testing {
namespace {

class SimplifiedCubes : public SimplificationGuarantees {
 protected:
  // Small leaves, so that there are many borders between them.
  [[nodiscard]] std::vector<TileMesh> leaves(std::size_t max_triangles = 300) {
    const ErrorBasedModel model = isosurfaces_.model({.isovalue = setting_.isovalue});
    return multitetra::finished_tiles(
        surface_in_cube(model, isosurfaces_.field(), root_,
                        {.isovalue = setting_.isovalue, .max_triangles = max_triangles}),
        root_);
  }
  [[nodiscard]] std::vector<TileMesh> simplified_tiles(const std::vector<TileMesh>& leaves,
                                                       double max_distance,
                                                       const SimplifiedTileLimits& limits) {
    std::map<OctreeCube, LatticeMesh> own;
    for (const TileMesh& leaf : leaves) own[leaf.cube] = leaf.mesh;
    const std::function<SimplifiedCube(const OctreeCube&)> in_cube = [&](const OctreeCube& cube) {
      std::vector<SimplifiedCube> children;
      for (int i = 0; cube.exponent > 0 && i < 8; ++i) children.push_back(in_cube(cube.child(i)));
      const auto mesh = own.find(cube);
      return join_simplified(
          cube, std::move(children),
          mesh == own.end() ? std::nullopt : std::optional(SimplifiedPiece(mesh->second, step_)),
          {.lattice_step = step_, .max_distance = max_distance}, limits);
    };
    std::vector<TileMesh> tiles;
    for (const SimplifiedTile& tile : all_tiles(in_cube(root_))) {
      Simplified left = tile.piece.result();
      tiles.push_back({tile.cube, std::move(left.mesh), left.bound});
    }
    return tiles;
  }
  [[nodiscard]] static LatticeMesh welded(const std::vector<TileMesh>& tiles) {
    return weld(tiles, kDefaultLatticeResolution);
  }
  [[nodiscard]] static std::size_t triangles(const std::vector<TileMesh>& tiles) {
    return std::accumulate(
        tiles.begin(), tiles.end(), std::size_t{0},
        [](std::size_t sum, const TileMesh& tile) { return sum + tile.mesh.triangles.size(); });
  }

  OctreeCube root_ = root_cube(isosurfaces_.field().grid());
};
INSTANTIATE_TEST_SUITE_P(Fields, SimplifiedCubes, ::testing::ValuesIn(settings()),
                         [](const auto& parameter) { return parameter.param.name; });

// These limits give from one tile to one tile per leaf.
const SimplifiedTileLimits kLimits[] = {{}, {.triangles = 200}, {.vertices_before = 500}, {1, 1}};

TEST_P(SimplifiedCubes, WeldToTheSurfaceWithItsTopologyAndBorder) {
  const auto border = border_edges(surface_.mesh);
  const MeshTopology whole = topology(surface_.mesh, kAnywhere);
  const auto parts = leaves();
  for (const double max_distance : kDistances) {
    for (const SimplifiedTileLimits& limits : kLimits) {
      const LatticeMesh small = welded(simplified_tiles(parts, max_distance, limits));
      const MeshTopology after = topology(small, kAnywhere);
      EXPECT_EQ(after.euler_characteristic, whole.euler_characteristic) << max_distance;
      EXPECT_EQ(after.components, whole.components) << max_distance;
      EXPECT_TRUE(after.is_sound()) << max_distance;
      EXPECT_EQ(border_edges(small), border) << max_distance;
      EXPECT_TRUE(is_subset(small, surface_.mesh)) << max_distance;
      EXPECT_EQ(inverted_vertices(small, surface_.mesh), 0) << max_distance;
    }
  }
}

// The bound always refers to the surface before simplification: it does not add up over levels.
TEST_P(SimplifiedCubes, BoundTheTwoSidedDistance) {
  const auto full = placed(surface_.mesh, step_);
  const auto parts = leaves();
  for (const double max_distance : kDistances) {
    for (const SimplifiedTileLimits& limits : {kLimits[0], kLimits[1]}) {
      const auto tiles = simplified_tiles(parts, max_distance, limits);
      double bound = 0;
      for (const TileMesh& tile : tiles) bound = std::max(bound, tile.simplification_bound);
      EXPECT_LE(bound, max_distance);
      const auto small = placed(welded(tiles), step_);
      EXPECT_LE(largest_distance(small, full), bound) << max_distance;
      EXPECT_LE(largest_distance(full, small), bound) << max_distance;
    }
  }
}

TEST_P(SimplifiedCubes, HaveNoMoreTrianglesThanSeparatelySimplifiedTiles) {
  const auto parts = leaves();
  for (const double max_distance : {0.25, 1e6}) {
    std::size_t apart = 0;
    for (const TileMesh& tile : parts) {
      apart += simplified(tile.mesh, {.lattice_step = step_, .max_distance = max_distance})
                   .mesh.triangles.size();
    }
    EXPECT_LE(triangles(simplified_tiles(parts, max_distance, {})), apart) << max_distance;
    EXPECT_LE(triangles(simplified_tiles(parts, max_distance, {})),
              triangles(simplified_tiles(parts, max_distance, {1, 1})))
        << max_distance;
  }
}

TEST_P(SimplifiedCubes, LieInTheirCubes) {
  for (const TileMesh& tile : simplified_tiles(leaves(), 0.25, {.triangles = 200})) {
    EXPECT_FALSE(tile.mesh.triangles.empty());
    for (const LatticePoint& vertex : tile.mesh.vertices) {
      EXPECT_TRUE(tile.cube.contains(vertex, kDefaultLatticeResolution)) << to_string(tile.cube);
    }
  }
}

TEST_P(SimplifiedCubes, KeepTheSurfaceWithoutABudget) {
  const auto parts = leaves();
  EXPECT_EQ(digest(welded(simplified_tiles(parts, 0, {}))), digest(welded(parts)));
}

TEST_P(SimplifiedCubes, ApplySmallerBudgetsOfLargerCubes) {
  std::vector<SimplifiedPiece> pieces;
  for (const TileMesh& leaf : leaves()) {
    pieces.emplace_back(leaf.mesh, step_);
    pieces.back().simplify(0.5);
  }
  SimplifiedPiece whole = SimplifiedPiece::joined(std::move(pieces));
  whole.simplify(0.1);
  const Simplified small = whole.result();
  EXPECT_LE(small.bound, 0.5);
  const auto full = placed(surface_.mesh, step_);
  EXPECT_LE(largest_distance(placed(small.mesh, step_), full), small.bound);
  EXPECT_LE(largest_distance(full, placed(small.mesh, step_)), small.bound);
  EXPECT_EQ(topology(small.mesh, kAnywhere).euler_characteristic,
            topology(surface_.mesh, kAnywhere).euler_characteristic);
}

// Joining without simplifying loses neither seams nor edges.
TEST_P(SimplifiedCubes, AllowJoiningPiecesInSeveralSteps) {
  std::vector<SimplifiedPiece> pieces;
  for (const TileMesh& leaf : leaves(100)) pieces.emplace_back(leaf.mesh, step_);
  for (const bool is_simplified : {false, true}) {
    if (is_simplified) {
      for (SimplifiedPiece& piece : pieces) piece.simplify(0.2);
    }
    std::vector<SimplifiedPiece> pairs;
    for (std::size_t i = 0; i < pieces.size(); i += 2) {
      const std::size_t count = std::min<std::size_t>(2, pieces.size() - i);
      const auto first = pieces.begin() + static_cast<std::ptrdiff_t>(i);
      pairs.push_back(SimplifiedPiece::joined({first, first + static_cast<std::ptrdiff_t>(count)}));
    }
    SimplifiedPiece whole = SimplifiedPiece::joined(std::move(pairs));
    whole.simplify(0.2);
    const Simplified small = whole.result();
    const auto full = placed(surface_.mesh, step_);
    EXPECT_LE(small.bound, 0.2);
    EXPECT_LE(largest_distance(placed(small.mesh, step_), full), small.bound);
    EXPECT_LE(largest_distance(full, placed(small.mesh, step_)), small.bound);
    const std::size_t at_once =
        simplified(surface_.mesh, {.lattice_step = step_, .max_distance = 0.2})
            .mesh.triangles.size();
    EXPECT_LE(small.mesh.triangles.size(), at_once + at_once / 4 + 8);
  }
}

TEST(SimplifiedSize, SumsBlocksWithoutBorder) {
  EXPECT_DOUBLE_EQ(
      remaining_share({.count = 3, .before = 1e6, .left = 2e5, .border_edges = 0}, 1, 1e8), 0.2);
  EXPECT_EQ(remaining_share({}, 1, 1e8), 1);
}

// Measured on the noisy head phantom of 128^3 at half a voxel: 506 480 triangles, simplified in
// blocks of 16 and 32 steps and in one piece.
const SimplifiedBlocks kBlocksOf16{
    .count = 215, .before = 506'480, .left = 54'464, .border_edges = 38'748};
const SimplifiedBlocks kBlocksOf32{
    .count = 56, .before = 506'480, .left = 36'554, .border_edges = 19'158};
constexpr double kInOnePiece = 18'926;

TEST(SimplifiedSize, OmitsTheCostOfBlockBorders) {
  const double seen = estimate_triangles_per_border_edge(kBlocksOf16, kBlocksOf32);
  for (const SimplifiedBlocks& blocks : {kBlocksOf16, kBlocksOf32}) {
    const double without_seeing = estimate_triangles_per_border_edge(blocks, blocks);
    for (const double at_border : {seen, without_seeing}) {
      EXPECT_NEAR(remaining_share(blocks, at_border, 506'480) * 506'480, kInOnePiece,
                  0.25 * kInOnePiece);
      EXPECT_GT(remaining_share(blocks, at_border, 1e9),
                remaining_share(blocks, at_border, 506'480))
          << "Many tiles have borders.";
      EXPECT_LT(remaining_share(blocks, at_border, 1e9), blocks.left / blocks.before);
    }
  }
}

TEST(SimplifiedSize, KeepsAShareOfATrianglePerBorderEdge) {
  const SimplifiedBlocks small{.count = 8, .before = 1e4, .left = 5000, .border_edges = 1000};
  SimplifiedBlocks large{.count = 1, .before = 1e4, .left = 4700, .border_edges = 500};
  EXPECT_DOUBLE_EQ(estimate_triangles_per_border_edge(small, large), 0.6);
  large.left = 100;
  EXPECT_EQ(estimate_triangles_per_border_edge(small, large), 1);
  large.left = 5100;
  EXPECT_EQ(estimate_triangles_per_border_edge(small, large), 0);
}

}  // namespace
}  // namespace multitetra::testing

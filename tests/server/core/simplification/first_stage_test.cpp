#include "server/core/simplification/detail/first_stage.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/vec3.hpp"
#include "tests/support/simplifying.hpp"

namespace multitetra::testing {
namespace {

class FirstStageTest : public SimplificationGuarantees {
 protected:
  // Edge lengths in lattice steps; the shortest is 1.
  Vec3 proportions_ = scaled(step_, 1 / *std::min_element(step_.begin(), step_.end()));

  [[nodiscard]] FirstStage simplified(double limit) const {
    const LatticeMesh& mesh = surface_.mesh;
    const PieceFrame frame{.proportions = proportions_, .origin = mesh.vertices.front()};
    std::vector<Vec3> positions;
    for (const LatticePoint& p : mesh.vertices) positions.push_back(frame.position(p));
    return first_stage(mesh, positions, PieceLimit(limit, frame, positions), std::nullopt, [] {});
  }
};
INSTANTIATE_TEST_SUITE_P(Fields, FirstStageTest, ::testing::ValuesIn(settings()),
                         [](const auto& parameter) { return parameter.param.name; });

// Error limits in lattice steps; 16 are half a voxel.
const double kInLatticeSteps[] = {16, 64, 1e6};

TEST_P(FirstStageTest, KeepsTopologyBorderAndVertices) {
  const MeshTopology before = topology(surface_.mesh, kAnywhere);
  for (const double limit : kInLatticeSteps) {
    const FirstStage stage = simplified(limit);
    const MeshTopology after = topology(stage.mesh, kAnywhere);
    EXPECT_EQ(after.euler_characteristic, before.euler_characteristic) << limit;
    EXPECT_EQ(after.components, before.components) << limit;
    EXPECT_TRUE(after.is_sound()) << limit;
    EXPECT_EQ(border_edges(stage.mesh), border_edges(surface_.mesh)) << limit;
    EXPECT_TRUE(is_subset(stage.mesh, surface_.mesh)) << limit;
    EXPECT_LT(stage.mesh.triangles.size(), surface_.mesh.triangles.size()) << limit;
  }
}

// The local error bounds distances from the simplified surface, the largest error those to it.
TEST_P(FirstStageTest, BoundsTheDistanceByTheLocalError) {
  const auto full = placed(surface_.mesh, proportions_);
  const NearestTriangle to_full(full);
  for (const double limit : kInLatticeSteps) {
    const FirstStage stage = simplified(limit);
    ASSERT_EQ(stage.errors.size(), stage.mesh.vertices.size());
    const double largest = *std::max_element(stage.errors.begin(), stage.errors.end());
    EXPECT_GT(largest, 0) << limit;
    EXPECT_LE(largest, 0.3 * limit) << limit;
    const auto coarse = placed(stage.mesh, proportions_);
    for (std::size_t t = 0; t < coarse.size(); t += coarse.size() / 1500 + 1) {
      for (const Vec3& shares : {Vec3{0.4, 0.3, 0.3}, Vec3{0.8, 0.1, 0.1}, Vec3{0, 0.5, 0.5}}) {
        Vec3 place = {0, 0, 0};
        double error = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          place = moved(place, shares[i], coarse[t][i]);
          error += shares[i] * double{stage.errors[stage.mesh.triangles[t][i]]};
        }
        EXPECT_LE(to_full.distance(place), error + 1e-6) << limit;
      }
    }
    EXPECT_LE(largest_distance(full, coarse), largest + 1e-6) << limit;
  }
}

}  // namespace
}  // namespace multitetra::testing

// The cells of a model fill the volume, and the surface in them is that of the model.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "server/extraction/model_cells.hpp"
#include "server/extraction/model_file.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/isosurfaces.hpp"

namespace multitetra::testing {
namespace {

struct Setting {
  std::string name;
  Volume volume;
  std::optional<double> outside;
  std::int32_t margin;
  double isovalue;
};

std::ostream& operator<<(std::ostream& out, const Setting& setting) { return out << setting.name; }

// Data that end with the grid, a little before it, long before it on one axis, and inside it.
std::vector<Setting> settings() {
  return {
      {"whole_grid", fields::gyroid(17, 0.3, 61), std::nullopt, 0, 0.1},
      {"last_samples_missing", fields::gyroid(15, 0, 62), std::nullopt, 0, 0.1},
      {"thin", fields::noise({23, 7, 4}, 63), std::nullopt, 0, 0.7},
      {"in_the_middle", fields::ball({13, 10, 9}, 3), std::nullopt, 9, 0.0},
      {"no_surface", fields::noise({10, 7, 14}, 64), std::nullopt, 3, 2.0},
      {"noise", fields::noise({12, 9, 10}, 65), std::nullopt, 0, 0.5},
      {"in_a_value", fields::noise({9, 11, 12}, 66), 0.0, 1, 0.6},
  };
}

class ModelCellsTest : public ::testing::TestWithParam<Setting> {
 protected:
  // Calls `visit(model cells, reference surface, field)` for several errors.
  template <typename Visit>
  void for_errors(ModelScope scope, double topology_tolerance, const Visit& visit) {
    const Setting& setting = GetParam();
    ReferenceIsosurfaces isosurfaces(setting.volume, setting.outside, setting.margin);
    for (const TopologyRule rule : {TopologyRule::kPaper, TopologyRule::kExact}) {
      for (const double threshold : {0.0, 0.7, 3.0, 1e9}) {
        SCOPED_TRACE(threshold);
        const Case c{.isovalue = setting.isovalue,
                     .threshold = threshold,
                     .rule = rule,
                     .topology_tolerance = topology_tolerance};
        visit(model_cells(isosurfaces.model(c), isosurfaces.field(), c.isovalue, scope),
              isosurfaces(c), isosurfaces.field());
      }
    }
  }
};

std::int64_t six_times_volume(const ModelCells& model, const std::array<std::int64_t, 4>& cell) {
  const auto point = [&](std::size_t i) { return model.points[static_cast<std::size_t>(cell[i])]; };
  return multitetra::six_times_volume(point(0), point(1), point(2), point(3));
}

bool is_crossed(const ModelCells& model, const std::array<std::int64_t, 4>& cell, double isovalue) {
  const auto positives = std::count_if(cell.begin(), cell.end(), [&](std::int64_t i) {
    return static_cast<double>(model.values[static_cast<std::size_t>(i)]) > isovalue;
  });
  return positives != 0 && positives != 4;
}

// All cells have the same orientation and their volumes add up to that of the data: there is no
// gap, so no overlap either.
TEST_P(ModelCellsTest, FillsTheVolume) {
  for_errors(ModelScope::kAll, 0, [&](const ModelCells& model, const Surface&, const Field& field) {
    std::int64_t sum = 0;
    for (const auto& cell : model.cells) {
      ASSERT_GT(six_times_volume(model, cell), 0);
      sum += six_times_volume(model, cell);
    }
    const GridPoint size = GetParam().outside ? field.grid().side() * GridPoint{1, 1, 1}
                                              : field.last_sample() - field.first_sample();
    EXPECT_EQ(sum, std::int64_t{6} * size.x * size.y * size.z);
  });
}

// With a topology tolerance the surface may extend into the void, beyond the model.
TEST_P(ModelCellsTest, ContainsOnlyCellsTheSurfaceCrosses) {
  const double isovalue = GetParam().isovalue;
  for (const double tolerance : {0, 4}) {
    for_errors(ModelScope::kAll, tolerance,
               [&](const ModelCells& model, const Surface& surface, const Field&) {
                 const auto crossed = std::count_if(
                     model.cells.begin(), model.cells.end(),
                     [&](const auto& cell) { return is_crossed(model, cell, isovalue); });
                 EXPECT_EQ(static_cast<std::uint64_t>(crossed), surface.active_tetrahedra);
               });
  }
}

TEST_P(ModelCellsTest, ReturnsTheCellsTheSurfaceCrosses) {
  const double isovalue = GetParam().isovalue;
  for_errors(ModelScope::kSurface, 0,
             [&](const ModelCells& model, const Surface& surface, const Field&) {
               EXPECT_EQ(model.cells.size(), surface.active_tetrahedra);
               for (const auto& cell : model.cells) {
                 ASSERT_TRUE(is_crossed(model, cell, isovalue));
               }
             });
}

// A point occurs twice if its sample is on the other side of the isovalue than its cell; all others
// occur once, with their own sample.
TEST_P(ModelCellsTest, HasTheSamplesAtItsPoints) {
  const double isovalue = GetParam().isovalue;
  for_errors(ModelScope::kAll, 0, [&](const ModelCells& model, const Surface&, const Field& field) {
    std::set<std::pair<GridPoint, bool>> seen;
    field.visit([&](const auto& sampled) {
      for (std::size_t i = 0; i < model.points.size(); ++i) {
        const bool is_positive = static_cast<double>(model.values[i]) > isovalue;
        EXPECT_TRUE(seen.emplace(model.points[i], is_positive).second);
        const float sample = sampled.at(model.points[i]);
        if ((static_cast<double>(sample) > isovalue) == is_positive) {
          EXPECT_EQ(model.values[i], sample);
        }
      }
    });
  });
}

INSTANTIATE_TEST_SUITE_P(Fields, ModelCellsTest, ::testing::ValuesIn(settings()),
                         [](const auto& parameter) { return parameter.param.name; });

TEST(ModelCells, OmitMaskedSamples) {
  const Volume volume = fields::masked_gyroid(24, 67);
  ReferenceIsosurfaces isosurfaces(volume, std::nullopt, 0);
  const ModelCells model = model_cells(isosurfaces.model({.isovalue = 0.05}), isosurfaces.field(),
                                       0.05, ModelScope::kAll);
  EXPECT_FALSE(model.cells.empty());
  EXPECT_TRUE(std::none_of(model.values.begin(), model.values.end(), is_void));
}

TEST(ModelFile, FlipsCellsInMirroredWorlds) {
  const ModelCells model = {.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                            .values = {1, 2, 3, 4},
                            .cells = {{0, 1, 2, 3}},
                            .sizes = {1}};
  const auto bytes_of = [](const std::vector<std::int64_t>& numbers) {
    return std::string(reinterpret_cast<const char*>(numbers.data()), 8 * numbers.size());
  };
  const std::string as_it_is = vtu_file(model, {});
  EXPECT_NE(as_it_is.find(bytes_of({0, 1, 2, 3})), std::string::npos);
  EXPECT_NE(as_it_is.find("NumberOfPoints=\"4\" NumberOfCells=\"1\""), std::string::npos);
  const std::string mirrored =
      vtu_file(model, {.columns = {Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}});
  EXPECT_NE(mirrored.find(bytes_of({0, 1, 3, 2})), std::string::npos);
}

}  // namespace
}  // namespace multitetra::testing

// Compares the implicit framework (models are predicates on points) with the paper's explicit one.

#include "tests/support/explicit_framework.hpp"

#include <gtest/gtest.h>

#include "server/core/errors/error_based_model.hpp"
#include "tests/support/fields.hpp"

namespace multitetra::testing {
namespace {

struct Setting {
  const char* name;
  Volume volume;
  std::optional<double> outside;
  std::int32_t margin;
  std::vector<double> isovalues;
};

std::ostream& operator<<(std::ostream& out, const Setting& setting) { return out << setting.name; }

std::vector<Setting> settings() {
  return {
      {"noise", fields::noise({9, 9, 9}, 7), std::nullopt, 0, {0.2, 0.5, 0.83}},
      {"stretched noise in zeros", fields::noise({8, 7, 5}, 8, {1, 2.5, 0.7}), 0.0, 1, {0.1, 0.6}},
      {"plateaus", fields::integer_noise({9, 8, 9}, 4, 9), 0.0, 0, {0, 0.5, 1, 2.5}},
      {"gyroid", fields::gyroid(17, 0.1, 10), std::nullopt, 0, {0.05}},
      {"masked gyroid", fields::masked_gyroid(17, 11), std::nullopt, 0, {0.05}},
      {"gyroid in a margin", fields::gyroid(15, 0.5, 12, {2, 1, 1}), -1.0, 1, {0.3}},
  };
}

class ExplicitFrameworkModels : public ::testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Fields, ExplicitFrameworkModels, ::testing::ValuesIn(settings()),
                         [](const auto& parameter) {
                           std::string name = parameter.param.name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST_P(ExplicitFrameworkModels, EqualTheModelsOfThePredicate) {
  const Setting& setting = GetParam();
  const Field field(setting.volume, setting.outside, setting.margin);
  ExplicitFramework framework(field);
  for (const double isovalue : setting.isovalues) {
    for (const ErrorMeasure measure : {ErrorMeasure::kPaper, ErrorMeasure::kCertified}) {
      for (const TopologyRule rule : {TopologyRule::kPaper, TopologyRule::kExact}) {
        const auto errors = std::make_shared<const SaturatedErrors>(field, isovalue, measure, rule);
        for (const double threshold : {0.0, 0.31, 0.77, 1.9, 1e9}) {
          for (const double tolerance : {0.0, 1.0, 2.0}) {
            SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", " << name(measure)
                                              << ", rule " << name(rule) << ", threshold "
                                              << threshold << ", tolerance " << tolerance);
            const ErrorBasedModel model(errors, {.thresholds = ThresholdMap::everywhere(threshold),
                                                 .topology_tolerance = tolerance});
            std::set<CornerSet> leaves;
            visit_leaves(model, field.grid(), root_cube(field.grid()),
                         [&](const Tetrahedron& t) { leaves.insert(corner_set(t)); });
            ASSERT_EQ(leaves, framework.fuse(isovalue, threshold, measure, rule, tolerance));
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace multitetra::testing

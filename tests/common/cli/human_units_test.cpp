#include "common/cli/human_units.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(HumanSuggestions, NameTissuesOnlyForComputedTomography) {
  DatasetInfo info;
  EXPECT_EQ(human_suggestions(info), "none");
  info.suggested_isovalues = {-900, -300.5, 300.5, 40, 2500};
  EXPECT_EQ(human_suggestions(info), "-900, -300.5, 300.5, 40, 2500");
  info.meaning.value_unit = "HU";
  EXPECT_EQ(human_suggestions(info),
            "-900, -300.5 (skin), 300.5 (bone), 40 (soft tissue), 2500 (enamel, metal)");
}

}  // namespace
}  // namespace multitetra

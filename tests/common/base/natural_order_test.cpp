#include "common/base/natural_order.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(NaturalOrder, ComparesRunsOfDigitsByValue) {
  const std::vector<std::string> sorted = {"a",    "a1",  "a02", "a2",     "a10",
                                           "a10b", "a11", "b0",  "b1.tif", "b10.tif"};
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    for (std::size_t j = 0; j < sorted.size(); ++j) {
      EXPECT_EQ(natural_order_less(sorted[i], sorted[j]), i < j) << sorted[i] << " " << sorted[j];
    }
  }
}

}  // namespace
}  // namespace multitetra

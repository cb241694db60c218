#include "common/base/json.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(ParseJson, RefusesMoreThan256Levels) {
  const auto nested = [](std::size_t levels) {
    return std::string(levels, '[') + std::string(levels, ']');
  };
  EXPECT_FALSE(parse_json(nested(256)).is_discarded());
  EXPECT_TRUE(parse_json(nested(257)).is_discarded());
  EXPECT_TRUE(parse_json(std::string(20'000'000, '[')).is_discarded());
}

TEST(ParseJson, CountsNoBracketsOfTexts) {
  const std::string brackets(1000, '[');
  EXPECT_EQ(parse_json("{\"a\": \"\\\"" + brackets + "\"}").at("a"), '"' + brackets);
}

}  // namespace
}  // namespace multitetra

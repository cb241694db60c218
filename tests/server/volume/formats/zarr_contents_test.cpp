#include "server/volume/formats/zarr/detail/zarr_contents.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <nlohmann/json.hpp>

namespace multitetra {
namespace {

using Json = nlohmann::json;

Json omero(const Json& channels) { return {{"omero", {{"channels", channels}}}}; }
Json window(const Json& start, const Json& end) {
  return {{"window", {{"start", start}, {"end", end}, {"min", 0}, {"max", 65535}}}};
}

struct Found {
  std::optional<DisplayWindow> window;
  std::vector<std::string> notices = {};
};
Found found_in(const Json& attributes, std::int64_t channel = 0) {
  Found found;
  found.window = zarr_window(attributes, channel, "cells.zarr", found.notices);
  return found;
}

TEST(ZarrWindow, IsFromStartToEndOfTheChannel) {
  const Json attributes = omero({window(100, 1500), window(-2.5, 7.25)});
  EXPECT_EQ(found_in(attributes).window, (DisplayWindow{100, 1500}));
  EXPECT_EQ(found_in(attributes, 1).window, (DisplayWindow{-2.5, 7.25}));
  EXPECT_EQ(found_in({{"ome", attributes}}, 1).window, (DisplayWindow{-2.5, 7.25}));
  EXPECT_TRUE(found_in(attributes, 1).notices.empty());
}

TEST(ZarrWindow, IsAbsentWithoutANoticeWhereTheSourceHasNone) {
  const Json limits = {{"window", {{"min", 0}, {"max", 255}}}};
  for (const Json& attributes :
       {Json(), Json::object(), Json({{"omero", "none"}}), omero("none"),
        omero(Json::array({window(1, 2)})), omero({window(1, 2), Json::object()}),
        omero({0, limits}), omero({0, {{"window", 5}}})}) {
    const Found found = found_in(attributes, 1);
    EXPECT_FALSE(found.window) << attributes;
    EXPECT_TRUE(found.notices.empty()) << attributes;
  }
}

TEST(ZarrWindow, IsIgnoredWithANoticeUnlessItHasTwoIncreasingNumbers) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const Json& bad :
       {window(5, 5), window(5, 4), window("100", "200"), window(kNaN, 1), window(0, kNaN),
        window(0, kInfinity), window(0, nullptr), window(Json::array(), 3), window(false, true)}) {
    const Found found = found_in(omero(Json::array({bad})));
    EXPECT_FALSE(found.window) << bad;
    ASSERT_EQ(found.notices.size(), 1u) << bad;
    EXPECT_NE(found.notices[0].find("'cells.zarr': the window of channel 0 from "),
              std::string::npos)
        << found.notices[0];
  }
}

}  // namespace
}  // namespace multitetra

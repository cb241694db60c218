#include "server/volume/formats/zarr/detail/zarr_json.hpp"

#include <gtest/gtest.h>

#include "common/base/json.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

TEST(ZarrJson, ReadsTheNumbersThatPythonWrites) {
  EXPECT_EQ(parse_zarr_json(R"({"_FillValue": NaN, "range": [-Infinity,Infinity], "units": "K"})"),
            Json({{"_FillValue", "NaN"}, {"range", {"-Infinity", "Infinity"}}, {"units", "K"}}));
  EXPECT_EQ(parse_zarr_json("NaN"), Json("NaN"));
}

TEST(ZarrJson, LeavesStringsAsTheyAre) {
  const Json odd = {{"say \"NaN\" or NaN", "-Infinity \\"}, {"NaN", "\\\" Infinity"}};
  EXPECT_EQ(parse_zarr_json(json_text(odd)), odd);
  Json with_nan = odd;
  std::string text = json_text(odd);
  text.back() = ',';
  with_nan["z"] = "NaN";
  EXPECT_EQ(parse_zarr_json(text + "\"z\":NaN}"), with_nan);
}

TEST(ZarrJson, RefusesOtherText) {
  for (const char* text : {"", "{", "NaNa", "{\"a\": Na}", "\"NaN", "\"\\", "[NaN", "-NaN",
                           "{NaN: 1", "Infinity Infinity"}) {
    EXPECT_TRUE(parse_zarr_json(text).is_discarded()) << text;
  }
}

}  // namespace
}  // namespace multitetra

#include "common/request/surface_query.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace multitetra {
namespace {

const RequestField& field(std::string_view name) {
  const auto fields = request_fields();
  return *std::find_if(fields.begin(), fields.end(),
                       [&](const RequestField& f) { return f.name == name; });
}

FieldError set(SurfaceQuery& query, std::string_view name, std::string_view text) {
  return field(name).set(field(name), text, query);
}

TEST(RequestFields, HaveTheirDocumentedDefaults) {
  const SurfaceQuery defaults;
  for (const RequestField& one : request_fields()) {
    if (one.default_text.empty()) continue;
    SurfaceQuery query;
    EXPECT_EQ(one.set(one, one.default_text, query), std::nullopt) << one.name;
    EXPECT_EQ(query.request, defaults.request) << one.name;
    EXPECT_EQ(query.coordinates, defaults.coordinates) << one.name;
    EXPECT_EQ(query.min_component, defaults.min_component) << one.name;
    EXPECT_EQ(query.colors.map, defaults.colors.map) << one.name;
    EXPECT_EQ(query.colors.is_logarithmic, defaults.colors.is_logarithmic) << one.name;
    EXPECT_EQ(query.colors.no_value, defaults.colors.no_value) << one.name;
  }
}

TEST(RequestFields, AcceptExactlyTheirDocumentedForms) {
  for (const RequestField& one : request_fields()) {
    if (one.value_syntax.find('|') == std::string_view::npos) continue;
    for (std::string_view rest = one.value_syntax; !rest.empty();) {
      const std::size_t end = std::min(rest.find('|'), rest.size());
      SurfaceQuery query;
      EXPECT_EQ(one.set(one, rest.substr(0, end), query), std::nullopt) << one.name;
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    SurfaceQuery query;
    const FieldError wrong = one.set(one, "nonsense", query);
    ASSERT_TRUE(wrong) << one.name;
    EXPECT_TRUE(wrong->starts_with("must be ")) << *wrong;
  }
}

TEST(RequestFields, AcceptSwitchesInBothForms) {
  SurfaceQuery query;
  EXPECT_FALSE(set(query, "intersection_free", "true"));
  EXPECT_TRUE(query.request.intersection_free);
  EXPECT_FALSE(set(query, "intersection_free", "off"));
  EXPECT_FALSE(query.request.intersection_free);
  EXPECT_FALSE(set(query, "simplify", "false"));
  EXPECT_FALSE(query.request.simplify);
  EXPECT_EQ(set(query, "simplify", "1"), "must be on, off, true or false");
}

TEST(RequestFields, AcceptAmountsWithUnits) {
  SurfaceQuery query;
  EXPECT_FALSE(set(query, "max_triangles", "1.5M"));
  EXPECT_EQ(query.request.max_triangles, 1'500'000U);
  EXPECT_FALSE(set(query, "max_bytes", "500KiB"));
  EXPECT_EQ(query.request.max_bytes, 512'000U);
  for (const char* text : {"", "-1", "2.5", "1X", "KiB", "1e30", "nan"}) {
    EXPECT_EQ(set(query, "max_bytes", text), "must be a whole number, such as 2MiB") << text;
  }
}

TEST(SurfaceQuery, RejectsErrorTogetherWithQuality) {
  DatasetInfo info;
  info.suggested_isovalues = {7};
  SurfaceQuery query;
  EXPECT_FALSE(set(query, "quality", "normal"));
  EXPECT_EQ(requests_for(query, info).value().front().error, 0.5);
  EXPECT_FALSE(set(query, "error", "0.5"));
  const auto refused = requests_for(query, info);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text,
            "error and quality exclude each other: a quality is a named error.");
}

TEST(SurfaceQuery, SharesABudgetOnlyIfItIsLargeEnough) {
  SurfaceQuery query;
  EXPECT_FALSE(set(query, "isovalue", "1,2,3"));
  EXPECT_FALSE(set(query, "max_triangles", "2"));
  EXPECT_FALSE(requests_for(query, DatasetInfo{}));
  EXPECT_FALSE(set(query, "max_triangles", "3"));
  EXPECT_EQ(requests_for(query, DatasetInfo{}).value().size(), 3U);
}

TEST(SurfaceQuery, NeedsADatasetForColors) {
  SurfaceQuery query;
  EXPECT_EQ(scalars_for(query).value(), std::nullopt);
  EXPECT_FALSE(set(query, "color_range", "0,5"));
  EXPECT_FALSE(scalars_for(query));
  EXPECT_FALSE(set(query, "color_by", "dose"));
  EXPECT_EQ(scalars_for(query).value()->limits->high, 5);
  EXPECT_FALSE(set(query, "color_scale", "log"));
  EXPECT_FALSE(scalars_for(query)) << "its range begins at 0";
}

TEST(ScalarsFor, AllowsAnotherWorldByColorAnyway) {
  SurfaceQuery query;
  query.color_by = "dose";
  EXPECT_FALSE(scalars_for(query).value()->in_any_world);
  EXPECT_FALSE(set(query, "color_anyway", "on"));
  EXPECT_TRUE(scalars_for(query).value()->in_any_world);
}

}  // namespace
}  // namespace multitetra

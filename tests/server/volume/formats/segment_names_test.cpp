// Segment names from NRRD headers, in one layer and in several.
#include "server/volume/formats/detail/segment_names.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/volume/detail/reader_messages.hpp"

namespace multitetra {
namespace {

TEST(SegmentNames, UseSampleValuesOfOneLayer) {
  const auto found = segments_in(
      "NRRD0004\ntype: uint8\nSegment0_Name:=liver\nSegment0_Color:=1 0.5 "
      "0\nSegment0_LabelValue:=3\n"
      "Segment1_Name:=no value\nSegment10_LabelValue:=7\r\nSegment10_Name:=rest of it\r\n"
      "Segment11_Name:=of liver, too\nSegment11_LabelValue:=3\n");
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0],
            (SourceLabel{.label = {.value = 3, .name = "liver", .color = 0xff8000}, .stored = 3}));
  EXPECT_EQ(found[1], (SourceLabel{.label = {.value = 7, .name = "rest of it"}, .stored = 7}));
  EXPECT_FALSE(have_layers(found));
}

TEST(SegmentNames, NumberSegmentsOfSeveralLayers) {
  const auto found = segments_in(
      "Segment0_Name:=liver\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
      "Segment1_Name:=tumour\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n"
      "Segment2_Name:=spleen\nSegment2_LabelValue:=2\nSegment2_Layer:=0\n"
      "Segment3_Name:=nowhere\nSegment3_LabelValue:=2\nSegment3_Layer:=-1\n"
      "Segment4_Name:=far\nSegment4_LabelValue:=2\nSegment4_Layer:=64\n");
  ASSERT_EQ(found.size(), 3U);
  EXPECT_TRUE(have_layers(found));
  EXPECT_EQ(found[0], (SourceLabel{.label = {.value = 1, .name = "liver"}, .stored = 1}));
  EXPECT_EQ(found[1],
            (SourceLabel{.label = {.value = 2, .name = "tumour"}, .stored = 1, .layer = 1}));
  EXPECT_EQ(found[2], (SourceLabel{.label = {.value = 3, .name = "spleen"}, .stored = 2}));
  EXPECT_EQ(segments_in("Segment0_LabelValue:=3\nSegment1_LabelValue:=4\nSegment1_Layer:=1\n", 1),
            (std::vector<SourceLabel>{{.label = {.value = 3}, .stored = 3}}));
  EXPECT_EQ(contents_from(contents_text({.labels = found}))->labels, found);
}

}  // namespace
}  // namespace multitetra

#include "server/volume/formats/detail/contour_level.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

constexpr const char* kVersion3 = R"(<?xml version="1.0"?>
<emd emdb_id="EMD-1234"><map><contour_list>
  <contour><level>0.01</level></contour>
  <contour primary="true"><level> 0.05 </level><source>AUTHOR</source></contour>
</contour_list></map></emd>)";

TEST(ContourLevel, ReadsThePrimaryLevelOfAnEmdbHeader) {
  EXPECT_EQ(contour_level_in_xml(kVersion3), 0.05);
}

TEST(ContourLevel, ReadsOlderEmdbHeaders) {
  EXPECT_EQ(
      contour_level_in_xml(
          "<emdEntry><map><contourLevel source=\"author\">2.5</contourLevel></map></emdEntry>"),
      2.5);
}

TEST(ContourLevel, ReadsThePrimaryLevelOfTheWebDescription) {
  EXPECT_EQ(contour_level_in_json(
                R"({"map": {"contour_list": {"contour": [{"primary": false, "level": 1},
                                                          {"primary": true, "level": 0.25}]}}})"),
            0.25);
}

TEST(ContourLevel, IgnoresOtherAndDamagedTexts) {
  EXPECT_FALSE(contour_level_in_xml("<emd><map/></emd>"));
  EXPECT_FALSE(contour_level_in_xml("<emd><map><contour><level>0.05</level>"));
  EXPECT_FALSE(contour_level_in_xml("<contour><level>much</level></contour>"));
  EXPECT_FALSE(contour_level_in_json("{\"map\": 3}"));
  EXPECT_FALSE(contour_level_in_json("{"));
}

TEST(ContourLevel, ReadsSidecarFilesAndArchiveHeaders) {
  const TemporaryFolder folder;
  const std::filesystem::path map = folder.file("map/emd_1234.map.gz", "");
  EXPECT_FALSE(sidecar_contour_level(map));
  (void)folder.file("header/emd-1234.xml", kVersion3);
  EXPECT_EQ(sidecar_contour_level(map), 0.05);
  (void)folder.file("map/emd_1234.json",
                    R"({"map": {"contour_list": {"contour": [{"level": 7.5}]}}})");
  EXPECT_EQ(sidecar_contour_level(map), 7.5);
}

}  // namespace
}  // namespace multitetra

#include "server/dataset/nrrd_header.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(NrrdHeader, AHeaderInOrderStaysAsItIs) {
  EXPECT_EQ(rewritten_nrrd_header("NRRD0004\ntype: short\nspacings: 1 2 3\n", "/d/v.nrrd"),
            std::nullopt);
  EXPECT_EQ(rewritten_nrrd_header("NRRD0004\nspace: left-posterior-superior\n"
                                  "space directions: (1,0,0) (0,1,0) (0,0,1)\n",
                                  "/d/v.nrrd"),
            std::nullopt);
  EXPECT_EQ(rewritten_nrrd_header("", "/d/v.nrrd"), std::nullopt);
  EXPECT_EQ(rewritten_nrrd_header("space: x\nspacings: 1 2 3\n", "/d/v.nrrd"), std::nullopt);
}

TEST(NrrdHeader, ASpaceThatOnlySpacingsUseGoes) {
  EXPECT_EQ(rewritten_nrrd_header("NRRD0004\r\nspacings: 1 2 3\r\nspace: 3D-left-handed\r\n"
                                  "data file: quarter.%d 1 93 1\r\n",
                                  "/d/v.nhdr"),
            "NRRD0004\nspacings: 1 2 3\ndata file: /d/quarter.%d 1 93 1\n");
}

TEST(NrrdHeader, ALateSpaceMovesUpAndAnAttachedHeaderIsSkipped) {
  EXPECT_EQ(rewritten_nrrd_header("NRRD0004\ntype: short\nspace origin: (1,2,3)\nspace: RAS\n",
                                  "/d/v.nrrd"),
            "NRRD0004\nspace: RAS\ntype: short\nspace origin: (1,2,3)\nline skip: 5\n"
            "data file: /d/v.nrrd\n");
}

TEST(NrrdHeader, AMissingSpaceHasThreeDimensions) {
  EXPECT_EQ(rewritten_nrrd_header("NRRD0004\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                                  "data file: LIST\na.raw\n/abs/b.raw\n",
                                  "/d/v.nhdr"),
            "NRRD0004\nspace dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
            "data file: LIST\n/d/a.raw\n/abs/b.raw\n");
}

}  // namespace
}  // namespace multitetra

// Interpretation of NRRD headers: world coordinates, axes, and data files.
#include "server/volume/formats/nrrd_file.hpp"

#include <gtest/gtest.h>

#include <string>

#include "common/image/nrrd_header.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using testing::expect_contains;

const std::string kBytes = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n";

class NrrdFile : public ::testing::Test {
 protected:
  ImageHeader header(const std::string& lines) { return open(kBytes + lines).header; }
  StoredVolume open(const std::string& lines, const VolumeChoice& choice = {}) {
    return open_nrrd(folder_.file("v.nrrd", lines + "\n" + std::string(24, 'x')), choice);
  }
  std::string refusal(const std::string& lines, const VolumeChoice& choice = {}) {
    try {
      (void)open(lines, choice);
      return "";
    } catch (const VolumeFileError& error) {
      return error.what();
    }
  }

  TemporaryFolder folder_;
};

TEST(NrrdHeader, LowersFieldsAndKeepsKeys) {
  const NrrdHeader header = parse_nrrd_header(
      "NRRD0005\r\n# a comment: none\r\nType: short\r\nDataFile: LIST 2\r\na.raw\r\nb: c.raw\r\n");
  EXPECT_EQ(header.field("type"), "short");
  EXPECT_EQ(header.field("data file"), "LIST 2");
  EXPECT_EQ(header.listed_files, (std::vector<std::string>{"a.raw", "b: c.raw"}));
  EXPECT_FALSE(header.has_end);
  const NrrdHeader keys =
      parse_nrrd_header("NRRD0005\nA Key:=a: value\nkinds: a \"b c\" (1, 2)\n\nx");
  EXPECT_EQ(keys.key("A Key"), "a: value");
  EXPECT_EQ(keys.axis_words("kinds", 3), (std::vector<std::string>{"a", "\"b c\"", "(1, 2)"}));
  EXPECT_TRUE(keys.axis_words("kinds", 2).empty());
  EXPECT_TRUE(keys.has_end);
  EXPECT_EQ(keys.bytes, 48U);
}

TEST_F(NrrdFile, ConvertsPatientSpacesToLps) {
  const std::string place = "space directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n";
  const auto check = [&](const std::string& space, const Vec3& signs) {
    SCOPED_TRACE(space);
    const ImageHeader lps = header("space: " + space + "\n" + place);
    EXPECT_EQ(lps.meaning.space, WorldSpace::kLps);
    EXPECT_EQ(lps.meaning.length_unit, "mm");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(lps.geometry.axes[axis][axis], signs[axis] * (1.0 + static_cast<double>(axis)));
      EXPECT_EQ(lps.geometry.origin[axis], signs[axis] * 10 * (1.0 + static_cast<double>(axis)));
    }
  };
  check("LPS", {1, 1, 1});
  check("left-posterior-superior", {1, 1, 1});
  check("RAS", {-1, -1, 1});
  check("right-anterior-superior-time", {-1, -1, 1});
  check("LAS", {1, -1, 1});
  check("Left-Anterior-Superior", {1, -1, 1});
  for (const char* space : {"scanner-xyz", "3D-right-handed", "3D-left-handed"}) {
    const ImageHeader own = header("space: " + std::string(space) + "\n" + place);
    EXPECT_EQ(own.meaning, PhysicalMeaning());
    EXPECT_EQ(own.geometry.origin, stated({10, 20, 30}));
  }
  expect_contains(refusal(kBytes + "space: up-down-strange\n" + place), "'up-down-strange'");
}

TEST_F(NrrdFile, AcceptsALateOrMissingSpace) {
  const std::string directions = "space directions: (1,0,0) (0,2,0) (0,0,3)\n";
  EXPECT_EQ(header(directions + "space origin: (1, 2, 3)\nspace: RAS\n").geometry.origin,
            stated({-1, -2, 3}));
  EXPECT_EQ(header(directions + "space origin: (1, 2, 3)\n").geometry.origin, stated({1, 2, 3}));
  const ImageHeader spacings = header("spacings: 1 2 3\nspace: RAS\nspace origin: (7,7,7)\n");
  EXPECT_EQ(spacings.meaning, PhysicalMeaning());
  EXPECT_EQ(spacings.geometry.origin, kNotStated);
  EXPECT_EQ(spacings.geometry.spacing, stated({1, 2, 3}));
}

TEST_F(NrrdFile, AppliesSpaceUnitsAndAxisMinimums) {
  const ImageHeader micrometres = header(
      "space: LPS\nspace units: \"um\" \"um\" \"um\"\nspace directions: (1,0,0) (0,2,0) "
      "(0,0,3)\n");
  EXPECT_EQ(micrometres.meaning.length_unit, "µm");
  // Also where the axes are not a patient's.
  for (const std::string lines : {"space dimension: 3\nspace units: \"um\" \"um\" \"um\"\nspace "
                                  "directions: (1,0,0) (0,2,0) (0,0,3)\n",
                                  "spacings: 1 2 3\nunits: \"um\" \"um\" \"um\"\n"}) {
    EXPECT_EQ(header(lines).meaning, (PhysicalMeaning{.length_unit = "µm"})) << lines;
  }
  const std::string mins = "spacings: 1 2 3\naxis mins: 10 20 30\n";
  EXPECT_EQ(header(mins).geometry.origin, stated({10.5, 21, 31.5}));
  EXPECT_EQ(header(mins + "centers: node node node\n").geometry.origin, stated({10, 20, 30}));
}

TEST_F(NrrdFile, ReadsComponentsFirstOrLast) {
  const std::string lines = "NRRD0004\ntype: uint8\nencoding: raw\n";
  std::vector<std::byte> slice(12);
  std::string bytes(24, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i);
  const auto first_slice = [&](const std::string& axes) {
    const StoredVolume volume =
        open_nrrd(folder_.file("c.nrrd", lines + axes + "\n" + bytes), {.first = true});
    EXPECT_EQ(volume.header.components, 2);
    EXPECT_EQ(volume.header.dims, (std::array<std::int64_t, 3>{3, 2, 2}));
    volume.slices->read(0, 1, slice.data());
    return std::vector<int>{std::to_integer<int>(slice[0]), std::to_integer<int>(slice[1]),
                            std::to_integer<int>(slice[2])};
  };
  EXPECT_EQ(first_slice("dimension: 4\nsizes: 2 3 2 2\nkinds: vector domain domain domain\n"),
            (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(first_slice("dimension: 4\nsizes: 3 2 2 2\nkinds: domain domain domain vector\n"),
            (std::vector<int>{0, 12, 1}));
  expect_contains(
      refusal(lines + "dimension: 4\nsizes: 3 2 2 2\nkinds: domain vector domain domain\n"),
      "neither the first nor the last");
}

TEST_F(NrrdFile, RejectsIncompleteHeaders) {
  const std::string shorts = "NRRD0004\ntype: int16\ndimension: 3\nsizes: 3 2 2\n";
  expect_contains(refusal(shorts + "encoding: raw\n"), "endian");
  expect_contains(refusal(shorts + "endian: little\n"), "encoding is ''");
  expect_contains(refusal(shorts + "endian: little\nencoding: zrl\n"), "encoding is 'zrl'");
  expect_contains(refusal("NRRD0004\ntype: block\ndimension: 3\nsizes: 3 2 2\nencoding: raw\n"),
                  "'block'");
  expect_contains(refusal("NRRD0004\ntype: uint8\ndimension: 1\nsizes: 24\nencoding: raw\n"),
                  "one dimension");
}

}  // namespace
}  // namespace multitetra

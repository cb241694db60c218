// Reading threshold images from NRRD files of all supported kinds.
#include "client/library/nrrd_thresholds.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "client/library/isolated_thresholds.hpp"
#include "common/sandbox/isolation.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

class NrrdThresholds : public ::testing::Test {
 protected:
  Result<ThresholdGrid> read(const std::string& bytes, double elsewhere = 9) {
    return read_nrrd_thresholds(folder_.file("grid.nrrd", bytes), elsewhere);
  }
  ThresholdGrid good(const std::string& bytes) {
    const auto grid = read(bytes);
    EXPECT_TRUE(grid) << grid.error().text;
    return grid.value_or(ThresholdGrid{});
  }
  std::string refusal(const std::string& bytes) {
    const auto grid = read(bytes);
    return grid ? "accepted" : grid.error().text;
  }

  TemporaryFolder folder_;
};

const std::string kPlace =
    "space dimension: 3\nspace directions: (0,2,0) (3,0,0) (0,0,4)\nspace origin: (5,6,7)\n";

std::string head(const std::string& type, const std::string& encoding,
                 const std::string& more = kPlace) {
  return "NRRD0004\n# a comment\ntype: " + type +
         "\ndimension: 3\nsizes: 2 2 1\nencoding: " + encoding + "\n" + more;
}

TEST_F(NrrdThresholds, ReadsOriginAndDirections) {
  const ThresholdGrid grid = good(head("float", "ascii") + "\n0.5 1\n2 nan\n");
  EXPECT_EQ(grid.dims, (std::array{2, 2, 1}));
  EXPECT_EQ(grid.index_to_world, (Affine{.columns = {Vec3{0, 2, 0}, Vec3{3, 0, 0}, Vec3{0, 0, 4}},
                                         .translation = {5, 6, 7}}));
  ASSERT_EQ(grid.thresholds.size(), 4U);
  EXPECT_EQ(grid.thresholds[0], 0.5F);
  EXPECT_EQ(grid.thresholds[2], 2.0F);
  EXPECT_TRUE(std::isnan(grid.thresholds[3]));
}

// The server accepts such headers in volumes, too.
TEST_F(NrrdThresholds, ReadsCrlfLinesAndCapitalizedFields) {
  const ThresholdGrid grid = good(
      "NRRD0005\rType: MET_FLOAT\rA note:=sizes: 9\rDimension: 3\rSizes: 2 1 1\r"
      "Encoding: ASCII\rLineSkip: 1\r\rskipped\n0.5 1\n");
  EXPECT_EQ(grid.dims, (std::array{2, 1, 1}));
  EXPECT_EQ(grid.thresholds, (std::vector<float>{0.5F, 1}));
}

TEST_F(NrrdThresholds, LieWhereVolumeReadersHaveThem) {
  const auto map = [&](const std::string& place, const std::string& unit = "") {
    const auto grid = read_nrrd_thresholds(
        folder_.file("placed.nrrd", head("float", "ascii", place) + "\n1 1 1 1\n"), 9, unit);
    EXPECT_TRUE(grid) << grid.error().text;
    return grid.value_or(ThresholdGrid{}).index_to_world;
  };
  // Cells begin at the axis' minimum, nodes lie there.
  const std::string axes = "spacings: 5 5 5\naxis mins: 2 2 2\n";
  EXPECT_EQ(map(axes).translation, (Vec3{4.5, 4.5, 4.5}));
  EXPECT_EQ(map(axes + "centerings: cell cell cell\n").translation, (Vec3{4.5, 4.5, 4.5}));
  EXPECT_EQ(map(axes + "centerings: node node node\n").translation, (Vec3{2, 2, 2}));
  EXPECT_EQ(map("axis mins: 0 0 0\naxis maxs: 4 6 1\n").columns[1], (Vec3{0, 3, 0}));
  // In the unit of the dataset.
  const std::string in_um = kPlace + "space units: \"um\" \"um\" \"um\"\n";
  EXPECT_EQ(map(in_um, "mm").translation, scaled(Vec3{5, 6, 7}, 1e-6 / 1e-3));
  EXPECT_EQ(map(in_um, "mm").columns[2], scaled(Vec3{0, 0, 4}, 1e-6 / 1e-3));
  for (const std::string unit : {"", "parsec", "um"}) {
    EXPECT_EQ(map(in_um, unit).translation, (Vec3{5, 6, 7}));
  }
  EXPECT_EQ(map(kPlace, "mm").translation, (Vec3{5, 6, 7}));
  for (const std::string place :
       {"spacings: 8,8,8\n", "spacings: 8 8\n", "space directions: (8,0,0) (0,8,x) (0,0,8)\n",
        "space directions: 8 0 0 0 8 0 0 0 8\n"}) {
    const std::string said = refusal(head("float", "ascii", place) + "\n1 1 1 1\n");
    EXPECT_NE(said.find("does not place its axis"), std::string::npos) << said;
  }
}

TEST_F(NrrdThresholds, ConvertsRasAndLasToLps) {
  const auto translation = [&](const std::string& space) {
    return good(head("float", "ascii",
                     "space: " + space + "\n" + kPlace.substr(kPlace.find('\n') + 1)) +
                "\n1 1 1 1\n")
        .index_to_world;
  };
  EXPECT_EQ(translation("left-posterior-superior").translation, (Vec3{5, 6, 7}));
  EXPECT_EQ(translation("RAS").translation, (Vec3{-5, -6, 7}));
  EXPECT_EQ(translation("right-anterior-superior").columns[0], (Vec3{0, -2, 0}));
  EXPECT_EQ(translation("LAS").translation, (Vec3{5, -6, 7}));
}

template <typename Number>
std::string big_and_little(bool is_big) {
  std::string bytes;
  for (const int value : {1, 2, 3, 4}) {
    const auto number = static_cast<Number>(value);
    std::string one(reinterpret_cast<const char*>(&number), sizeof number);
    if (is_big) std::reverse(one.begin(), one.end());
    bytes += one;
  }
  return bytes;
}

TEST_F(NrrdThresholds, ReadsAnyTypeAndByteOrder) {
  const auto check = [&]<typename Number>(const std::string& type, Number) {
    for (const bool is_big : {false, true}) {
      const std::string endian = is_big ? "endian: big\n" : "endian: little\n";
      EXPECT_EQ(good(head(type, "raw", endian) + "\n" + big_and_little<Number>(is_big)).thresholds,
                (std::vector<float>{1, 2, 3, 4}))
          << type;
    }
  };
  check("signed char", std::int8_t{});
  check("uchar", std::uint8_t{});
  check("short", std::int16_t{});
  check("unsigned short", std::uint16_t{});
  check("int32_t", std::int32_t{});
  check("uint", std::uint32_t{});
  check("long long", std::int64_t{});
  check("uint64", std::uint64_t{});
  check("float", float{});
  check("double", double{});
}

std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string packed(1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

TEST_F(NrrdThresholds, ReadsPackedOffsetAndDetachedData) {
  const std::string raw = big_and_little<float>(false);
  const std::vector<float> expected = {1, 2, 3, 4};
  const std::string little = "endian: little\n";
  EXPECT_EQ(good(head("float", "gzip", little) + "\n" + gzipped(raw)).thresholds, expected);
  EXPECT_EQ(
      good(head("float", "gz", little + "byte skip: 3\n") + "\n" + gzipped("abc" + raw)).thresholds,
      expected);
  EXPECT_EQ(good(head("float", "raw", little + "byte skip: -1\n") + "\nabcde" + raw).thresholds,
            expected);
  EXPECT_EQ(good(head("float", "raw", little + "line skip: 2\nbyte skip: 1\n") + "\na\nb\n!" + raw)
                .thresholds,
            expected);
  folder_.file("samples.bin", raw);
  EXPECT_EQ(good(head("float", "raw", little + "data file: samples.bin\n")).thresholds, expected);
  EXPECT_EQ(good(head("float", "raw", little + "datafile: samples.bin\n")).thresholds, expected);
}

TEST_F(NrrdThresholds, UsesSpacingsWithoutDirections) {
  const ThresholdGrid grid = good(
      "NRRD0001\r\ntype: uchar\r\ndimension: 2\r\nsizes: 2 1\r\nspacings: 3 nan\r\nencoding: "
      "raw\r\n\r\n\x07\x08");
  EXPECT_EQ(grid.dims, (std::array{2, 1, 1}));
  EXPECT_EQ(grid.index_to_world.columns[0], (Vec3{3, 0, 0}));
  EXPECT_EQ(grid.index_to_world.columns[1], (Vec3{0, 1, 0}));
  EXPECT_EQ(grid.thresholds, (std::vector<float>{7, 8}));
}

TEST_F(NrrdThresholds, ShrinksLargeImagesByMinimum) {
  std::string samples(80 * 80 * 80, '\5');
  samples[0] = 1;
  const ThresholdGrid grid =
      good("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 80 80 80\nencoding: raw\n\n" + samples);
  EXPECT_LE(grid.thresholds.size(), kMaxGridThresholds);
  EXPECT_EQ(grid.thresholds.front(), 1.0F);
  EXPECT_EQ(grid.thresholds.back(), 5.0F);
}

TEST_F(NrrdThresholds, NamesUnreadableFilesWithTheReason) {
  EXPECT_NE(
      read_nrrd_thresholds(folder_.path() / "none", 1).error().text.find("the file does not exist"),
      std::string::npos);
  EXPECT_NE(refusal("no image").find("grid.nrrd\": it is not an NRRD file; give an NRRD file."),
            std::string::npos)
      << refusal("no image");
  EXPECT_NE(
      refusal(head("float", "raw", "endian: little\n") + "\nshort").find("ends after 5 of 16"),
      std::string::npos);
  EXPECT_NE(refusal(head("float", "raw", "") + "\n" + std::string(16, '1')).find("byte order"),
            std::string::npos);
  EXPECT_NE(refusal(head("block", "raw") + "\n").find("its type is \"block\""), std::string::npos);
  EXPECT_NE(refusal(head("float", "bzip2") + "\n").find("its encoding is \"bzip2\""),
            std::string::npos);
  EXPECT_NE(refusal(head("float", "ascii") + "\n1 2 3").find("it has 3 of 4 samples"),
            std::string::npos);
  EXPECT_NE(refusal(head("float", "ascii") + "\n1 2 x 3").find("\"x\" is not a number"),
            std::string::npos);
  EXPECT_NE(refusal(head("float", "gzip", "endian: little\n") + "\nnot zipped").find("damaged"),
            std::string::npos);
  EXPECT_NE(refusal(head("float", "raw", "data file: ../secret\n")).find("in another folder"),
            std::string::npos);
  EXPECT_NE(refusal(head("float", "raw", "data file: slice%03d.raw 1 2 1\n")).find("several files"),
            std::string::npos);
  const auto too_large =
      read("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1000 1000 1000\nencoding: raw\n\n");
  EXPECT_EQ(too_large.error().code, ErrorCode::kLimitExceeded);
  EXPECT_NE(refusal("NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nencoding: raw\n\n")
                .find("4 dimensions"),
            std::string::npos);
}

TEST_F(NrrdThresholds, ReadsOrRejectsDamagedFiles) {
  std::mt19937 random(3);
  const std::string raw = big_and_little<float>(false);
  for (const std::string& whole :
       {head("float", "ascii") + "\n0.5 1\n2 nan\n",
        head("float", "gzip", "endian: little\n" + kPlace) + "\n" + gzipped(raw)}) {
    for (int i = 0; i < 500; ++i) {
      std::string bytes = whole;
      if (i % 2 == 0) bytes.resize(random() % bytes.size());
      for (int j = 0; j < i % 4 && !bytes.empty(); ++j)
        bytes[random() % bytes.size()] = static_cast<char>(random());
      const auto grid = read(bytes);
      if (grid) {
        EXPECT_FALSE(grid->thresholds.empty());
      }
    }
  }
}

TEST_F(NrrdThresholds, AreReadInAProcessThatSeesNoOtherFiles) {
  const TemporaryFolder other;
  const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
  const auto whole = folder_.file("grid.nrrd", header + "\n" + std::string(8, '\2'));
  const auto grid = read_thresholds_isolated(whole, 9, "");
  ASSERT_TRUE(grid) << grid.error().text;
  EXPECT_EQ(*grid, *read_nrrd_thresholds(whole, 9));
  const auto damaged = folder_.file("short.nrrd", header + "\n");
  EXPECT_EQ(read_thresholds_isolated(damaged, 9, "").error().text,
            read_nrrd_thresholds(damaged, 9).error().text);
  std::filesystem::create_symlink(other.file("secret", std::string(8, '\3')),
                                  folder_.path() / "secret.raw");
  const auto linked = folder_.file("linked.nrrd", header + "data file: secret.raw\n\n");
  EXPECT_TRUE(read_nrrd_thresholds(linked, 9));
  if (isolation_of_this_kernel().landlock == 0)
    GTEST_SKIP() << "NOT TESTED: this kernel has no Landlock.";
  EXPECT_FALSE(read_thresholds_isolated(linked, 9, ""));
}

}  // namespace
}  // namespace multitetra

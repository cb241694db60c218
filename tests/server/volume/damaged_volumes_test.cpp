// Non-finite numbers, and files that are damaged or not what they claim to be.
#include "server/volume/volume_files.hpp"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string vti(const std::string& type, const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    char word[32];
    std::snprintf(word, sizeof(word), "%.17g ", number);
    text += word;
  }
  return "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 3 0 2 0 1\">"
         "<Piece Extent=\"0 3 0 2 0 1\"><PointData><DataArray type=\"" +
         type + "\" Name=\"a\" format=\"ascii\">" + text +
         "</DataArray></PointData></Piece></ImageData></VTKFile>";
}

// The same numbers in every format that supports the type.
template <typename Number>
std::vector<fs::path> written(const TemporaryFolder& folder, const std::vector<double>& numbers,
                              const std::string& nrrd_type, const std::string& meta_type,
                              const std::string& vtk_type, const std::string& vti_type,
                              NiftiType nifti_type) {
  const std::string little = packed<Number>(numbers);
  const std::string big = packed<Number>(numbers, Endian::kBig);
  const std::string lines = "type: " + nrrd_type + "\ndimension: 3\nsizes: 4 3 2\n";
  std::vector<fs::path> files = {
      folder.file("v.nrrd", nrrd(lines + "encoding: raw\nendian: little\n", little)),
      folder.file("z.nrrd", nrrd(lines + "encoding: gzip\nendian: big\n", deflated(big, true))),
      folder.file("v.mha", meta_image_header(meta_type, "LOCAL") + little),
      folder.file("v.vtk", legacy_vtk("BINARY", vtk_type, big)),
      folder.file("v.nii", nifti(nifti_type, little, Endian::kLittle)),
      folder.file("v.nii.gz", deflated(nifti(nifti_type, big, Endian::kBig), true)),
      folder.file("v.vti", vti(vti_type, numbers)),
  };
  return files;
}

void expect_numbers(const std::vector<fs::path>& files, const std::vector<double>& numbers,
                    SampleType type) {
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const Volume volume = read_volume(file);
    EXPECT_EQ(volume.type(), type);
    std::visit(
        [&](const auto& samples) {
          ASSERT_EQ(samples.size(), numbers.size());
          for (std::size_t i = 0; i < numbers.size(); ++i) {
            const auto sample = static_cast<double>(samples[i]);
            if (std::isfinite(numbers[i])) {
              EXPECT_EQ(sample, static_cast<double>(static_cast<float>(numbers[i]))) << i;
            } else {
              EXPECT_TRUE(std::isnan(sample)) << i;
            }
          }
        },
        volume.samples);
  }
}

class VolumeFileRobustness : public ::testing::Test {
 protected:
  // Returns the message of the VolumeFileError that opening and reading `file` throws.
  static std::string error_of(const fs::path& file, const VolumeFileOptions& options = {}) {
    try {
      (void)read_volume(file, options);
    } catch (const VolumeFileError& error) {
      return error.what();
    }
    ADD_FAILURE() << file << " was read and should not have been";
    return {};
  }

  TemporaryFolder folder_;
};

// ---- numbers

TEST_F(VolumeFileRobustness, ReadsNanInfinityAndExtremesEquallyInEveryFormat) {
  std::vector<double> numbers = values();
  numbers[3] = kNaN;
  numbers[5] = kInfinity;
  numbers[7] = -kInfinity;
  numbers[9] = std::numeric_limits<float>::max();
  numbers[10] = std::numeric_limits<float>::lowest();
  numbers[11] = -0.0;
  expect_numbers(
      written<float>(folder_, numbers, "float", "MET_FLOAT", "float", "Float32", {16, 32}), numbers,
      SampleType::kF32);
  expect_numbers(
      written<double>(folder_, numbers, "double", "MET_DOUBLE", "double", "Float64", {64, 64}),
      numbers, SampleType::kF32);
  std::vector<double> integers = values();
  integers[0] = std::numeric_limits<std::int16_t>::min();
  integers[1] = std::numeric_limits<std::int16_t>::max();
  expect_numbers(
      written<std::int16_t>(folder_, integers, "int16", "MET_SHORT", "short", "Int16", {4, 16}),
      integers, SampleType::kI16);
  integers[0] = 0;
  integers[1] = std::numeric_limits<std::uint16_t>::max();
  expect_numbers(written<std::uint16_t>(folder_, integers, "uint16", "MET_USHORT", "unsigned_short",
                                        "UInt16", {512, 16}),
                 integers, SampleType::kU16);
  integers[0] = std::numeric_limits<std::int32_t>::min();
  integers[1] = 16777216;
  expect_numbers(
      written<std::int32_t>(folder_, integers, "int32", "MET_INT", "int", "Int32", {8, 32}),
      integers, SampleType::kF32);
}

TEST_F(VolumeFileRobustness, ReportsTheLargestRoundingError) {
  std::vector<double> numbers = values();
  numbers[4] = 9007199254740993.0;  // Already rounded to 2^53 as a double.
  numbers[5] = 16777217;            // Not a float: off by one.
  std::vector<std::string> notices;
  const fs::path file =
      folder_.file("v.nrrd", nrrd("type: int64\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 "
                                  "1\nencoding: raw\nendian: little\n",
                                  packed<std::int64_t>(numbers)));
  (void)read_volume(file, {.notice = [&](const std::string& text) { notices.push_back(text); }});
  ASSERT_EQ(notices.size(), 1u);
  expect_contains(notices[0], "i64 become f32, with errors of at most 1");
}

TEST_F(VolumeFileRobustness, SelectsComponentsByNumberMagnitudeOrLuminance) {
  std::string samples;
  for (int i = 0; i < 24; ++i) samples += {static_cast<char>(2 * i), static_cast<char>(3 * i), 6};
  const fs::path file = folder_.file(
      "rgb.nrrd", nrrd("dimension: 4\nsizes: 3 4 3 2\nkinds: RGB-color domain domain domain\n"
                       "encoding: raw\ntype: uint8\n",
                       samples));
  const auto read = [&](const std::string& component) {
    return read_volume(file, {.choice = {.component = ComponentChoice::from(component).value()}});
  };
  expect_contains(error_of(file), "--component");
  EXPECT_EQ(std::get<std::vector<std::uint8_t>>(read("1").samples)[5], 15);
  EXPECT_FLOAT_EQ(std::get<std::vector<float>>(read("magnitude").samples)[1], 7);
  EXPECT_FLOAT_EQ(std::get<std::vector<float>>(read("luminance").samples)[1],
                  0.2126F * 2 + 0.7152F * 3 + 0.0722F * 6);
  EXPECT_THROW((void)read("3"), VolumeFileError);
  EXPECT_FALSE(ComponentChoice::from("-1"));
  EXPECT_FALSE(ComponentChoice::from("first"));
}

TEST_F(VolumeFileRobustness, SelectsTimesOfNifti) {
  std::vector<double> later = values();
  for (double& number : later) number += 1000;
  const std::string both = packed<std::int16_t>(values()) + packed<std::int16_t>(later);
  const fs::path file =
      folder_.file("two.nii", nifti({4, 16}, both, Endian::kLittle, {1, 0}, {2, 1}));
  expect_contains(error_of(file), "--time");
  expect_contains(error_of(file, {.choice = {.time = 2}}), "0 to 1");
  const Volume volume = read_volume(file, {.choice = {.time = 1}});
  EXPECT_EQ(std::get<std::vector<std::int16_t>>(volume.samples)[0], 1007);
}

TEST_F(VolumeFileRobustness, ReadsCubeFilesWithTheThirdAxisFastest) {
  std::string text = "density\nof nothing\n";
  const std::string grid =
      "    1.0    2.0    3.0\n    2    0.5    0    0\n    3    0    0.25    0\n"
      "    4    0    0    0.125\n    8    0.0    1    1    1\n";
  std::string numbers;
  for (int i = 0; i < 24; ++i) numbers += std::to_string(i) + ".5E+00" + (i % 6 == 5 ? "\n" : "  ");
  const Volume volume = read_volume(folder_.file("v.cube", text + "    1" + grid + numbers));
  EXPECT_EQ(volume.dims, (std::array<std::int32_t, 3>{4, 3, 2}));
  EXPECT_EQ(std::get<std::vector<float>>(volume.samples)[23], 23.5F);
  EXPECT_EQ(volume.index_to_world({1, 0, 0}), (Vec3{1, 2, 3.125}));
  EXPECT_EQ(volume.index_to_world({0, 0, 1}), (Vec3{1.5, 2, 3}));
  EXPECT_EQ(volume.meaning.length_unit, "bohr");
  // Two orbitals: two numbers at every point.
  const fs::path two =
      folder_.file("two.cube", text + "   -1" + grid + "    2    5    6\n" + numbers + numbers);
  expect_contains(error_of(two), "--component");
  const Volume second =
      read_volume(two, {.choice = {.component = ComponentChoice::from("1").value()}});
  EXPECT_EQ(std::get<std::vector<float>>(second.samples)[1], 3.5F);
  expect_contains(error_of(folder_.file("v.cube", text + "    1" + grid + numbers.substr(0, 90))),
                  "numbers it ends");
}

// A complete copy would not help: the file is as long as it should be, but something else.
TEST_F(VolumeFileRobustness, AdvisesACopyOnlyOfShortFiles) {
  const std::string other(400, 'x');
  for (const char* name : {"v.nii", "v.mgh", "v.npy", "v.cube"}) {
    expect_contains(error_of(folder_.file(name, other)), "Check its name");
  }
}

// ---- headers that crash readers

TEST_F(VolumeFileRobustness, SurvivesHeadersThatCrashLibraries) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string good =
      "type: int16\ndimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: little\n";
  const std::string long_word(5000, 'x');
  const std::string digits(3'000'000, '7');
  std::string circle = tiff({std::string(12, 'x'), std::string(12, 'y')}, 1);
  circle.replace(8 + 2 + 12 * 9, 4, packed<std::uint32_t>({8}));  // The first page links to itself.
  const std::vector<std::pair<std::string, std::string>> files = {
      {"dimension.nrrd", nrrd("type: int16\ndimension: 10\nsizes: 1 1 1 1 1 1 1 1 4 3 2\n"
                              "encoding: raw\nendian: little\nspace dimension: 9\n"
                              "space directions: (1,0,0) (0,1,0) (0,0,1)\n",
                              shorts)},
      {"fields.nrrd", nrrd(good + "kinds: " + long_word + "\nlabels: \"" + long_word + "\"\n" +
                               "space: " + long_word + "\n",
                           shorts)},
      {"digits.nrrd", nrrd("type: int16\ndimension: 3\nsizes: 4 3 2\nencoding: ascii\n", digits)},
      {"type.vtk", legacy_vtk("BINARY", long_word, shorts)},
      {"ndims.mha",
       "ObjectType = Image\nNDims = -1\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
       "ElementDataFile = LOCAL\n" +
           shorts},
      {"ndims9.mha",
       "ObjectType = Image\nNDims = 99999\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
       "ElementDataFile = LOCAL\n" +
           shorts},
      {"circle.tif", circle},
      {"nothing.mha", "ObjectType" + std::string(200'000, ' ')},
      {"nothing.nrrd", "NRRD0004\n" + std::string(5'000'000, ' ')},
      {"nothing.vti", "<VTKFile type=\"ImageData\" a=\"" + std::string(200'000, ' ')},
      {"entities.vti", "<?xml version=\"1.0\"?><!DOCTYPE VTKFile [<!ENTITY a \"b\">]><VTKFile/>"},
  };
  for (const auto& [name, bytes] : files) {
    SCOPED_TRACE(name);
    const fs::path file = folder_.file(name, bytes);
    expect_contains(error_of(file), name);
  }
}

TEST_F(VolumeFileRobustness, RejectsIrregularDataFilesAndThoseOutsideTheFolder) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string lines =
      "NRRD0004\ntype: int16\ndimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: little\n";
  folder_.file("secret.raw", shorts);
  ASSERT_EQ(mkfifo((folder_.path() / "in/pipe").c_str(), 0600), -1);  // The folder does not exist
                                                                      // yet.
  const fs::path outside = folder_.file("in/out.nhdr", lines + "data file: ../secret.raw\n");
  ASSERT_EQ(mkfifo((folder_.path() / "in/pipe").c_str(), 0600), 0);
  fs::create_symlink("../secret.raw", folder_.path() / "in/link.raw");
  const std::string absolute = (folder_.path() / "secret.raw").string();
  for (const fs::path& file :
       {outside, folder_.file("in/absolute.nhdr", lines + "data file: " + absolute + "\n"),
        folder_.file("in/link.nhdr", lines + "data file: link.raw\n"),
        folder_.file("in/list.nhdr", lines + "data file: LIST 3\n../secret.raw\n"),
        folder_.file("in/out.mhd", meta_image_header("MET_SHORT", "../secret.raw")),
        folder_.file("in/v.dat",
                     "ObjectFileName: ../secret.raw\nResolution: 4 3 2\nFormat: SHORT\n")}) {
    SCOPED_TRACE(file);
    expect_contains(error_of(file), "--follow");
    EXPECT_EQ(read_volume(file, {.choice = {.allow_external_files = true}}).dims, kDims);
  }
  for (const fs::path& file : {folder_.file("in/pipe.nhdr", lines + "data file: pipe\n"),
                               folder_.file("in/pipe.mhd", meta_image_header("MET_SHORT", "pipe")),
                               folder_.path() / "in/pipe"}) {
    SCOPED_TRACE(file);
    expect_contains(error_of(file), "not a regular file");
  }
}

TEST_F(VolumeFileRobustness, ReadsOrRejectsExtremeShapes) {
  const auto raw = [](std::array<std::int32_t, 3> dims) { return RawLayout{.dims = dims}; };
  const Volume thin =
      read_volume(folder_.file("thin.raw", std::string(4000, 'x')), {.raw = raw({4000, 1, 1})});
  EXPECT_EQ(thin.dims, (std::array<std::int32_t, 3>{4000, 1, 1}));
  expect_contains(error_of(folder_.file("wide.raw", "x"), {.raw = raw({20000, 20000, 1})}),
                  "20000 x 20000 x 1");
  const Volume empty = read_volume(folder_.file(
      "nan.nrrd", nrrd("type: float\ndimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: little\n",
                       packed<float>(std::vector<double>(24, kNaN)))));
  EXPECT_TRUE(std::isnan(std::get<std::vector<float>>(empty.samples)[23]));
  for (const char* sizes : {"4294967296 4294967296 4294967296", "-4 3 2", "0 3 2", "4 3"}) {
    SCOPED_TRACE(sizes);
    const fs::path file = folder_.file(
        "v.nrrd",
        nrrd(std::string("type: double\ndimension: 3\nencoding: raw\nendian: little\nsizes: ") +
                 sizes + "\n",
             "few"));
    expect_contains(error_of(file), "v.nrrd");
  }
}

// ---- random damage

// MULTITETRA_MUTATIONS overrides the default.
int mutations() {
  const char* const more = std::getenv("MULTITETRA_MUTATIONS");
  return more == nullptr ? 8 : std::atoi(more);
}

TEST_F(VolumeFileRobustness, ReadsOrRejectsRandomlyChangedFiles) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string lines = "type: int16\ndimension: 3\nsizes: 4 3 2\n";
  const std::string small = deflated(shorts, false);
  const std::vector<std::pair<std::string, std::string>> whole = {
      {"v.nrrd", nrrd(lines + "encoding: raw\nendian: little\nspace: RAS\n"
                              "space directions: (1,0,0) (0,1,0) (0,0,1)\n",
                      shorts)},
      {"z.nrrd", nrrd(lines + "encoding: gzip\nendian: little\n", deflated(shorts, true))},
      {"v.mha", meta_image_header("MET_SHORT", "LOCAL") + shorts},
      {"z.mha", meta_image_header("MET_SHORT", "LOCAL", "CompressedData = True\n") + small},
      {"v.nii", nifti({4, 16}, shorts, Endian::kLittle)},
      {"v.nii.gz", deflated(nifti({4, 16}, shorts, Endian::kLittle), true)},
      {"b.vtk", legacy_vtk("BINARY", "short", shorts)},
      {"v.tif", tiff({shorts.substr(0, 24), shorts.substr(24)}, 2)},
      {"t.nrrd", nrrd(lines + "encoding: text\n", "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18")},
      {"h.nrrd", nrrd(lines + "encoding: hex\nendian: big\n", std::string(96, '7'))},
      {"v.vti", vti("Int16", values())},
  };
  std::mt19937 random(7);
  for (const auto& [name, bytes] : whole) {
    for (int i = 0; i < mutations(); ++i) {
      std::string damaged = bytes;
      for (int changes = 1 + static_cast<int>(random() % 4); changes > 0; --changes) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0:
            damaged[at] = static_cast<char>(random());
            break;
          case 1:
            damaged[at] = "0123456789-. \n%"[random() % 15];
            break;
          case 2:
            damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 40));
            break;
          default:
            damaged.erase(at, 1 + random() % 20);
        }
        if (damaged.empty()) damaged = "x";
      }
      const fs::path file = folder_.file(name, damaged);
      try {
        (void)read_volume(file);
      } catch (const VolumeFileError& error) {
        EXPECT_NE(std::string(error.what()).find("Cannot read"), std::string::npos);
      }
    }
  }
}

}  // namespace
}  // namespace multitetra

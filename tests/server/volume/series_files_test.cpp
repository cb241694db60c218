// Files that contain several volumes: their times, and the volume of each time.

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/volume_files.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

constexpr int kTimes = 3;

std::vector<double> values_at(int time) {
  std::vector<double> numbers = values();
  for (double& number : numbers) number += 1000 * time;
  return numbers;
}

std::string shorts_at(int time) { return packed<std::int16_t>(values_at(time)); }
std::string all_times() { return shorts_at(0) + shorts_at(1) + shorts_at(2); }

// The numbers of all times, interleaved at every sample.
std::string interleaved() {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < values().size(); ++i) {
    for (int time = 0; time < kTimes; ++time) numbers.push_back(values_at(time)[i]);
  }
  return packed<std::int16_t>(numbers);
}

const std::string kFour = "type: int16\ndimension: 4\nendian: little\n";
const std::string kInSpace =
    kFour + "space: left-posterior-superior\nsizes: 4 3 2 3\nkinds: domain domain domain time\n" +
    "space directions: (1,0,0) (0,2,0) (0,0,3) none\nspace origin: (10,20,30)\n" +
    "units: \"mm\" \"mm\" \"mm\" \"s\"\n";

class SeriesFiles : public ::testing::Test {
 protected:
  fs::path file(const std::string& name, const std::string& bytes) {
    return folder_.file(name, bytes);
  }
  static VolumeContents contents(const fs::path& path, VolumeChoice choice = {}) {
    choice.first = true;
    return open_volume(path, {.choice = choice})->contents();
  }
  // Expects every time to be the volume written, and an error if none is chosen.
  void expect_times(const fs::path& path, const SourceTimes& times) {
    SCOPED_TRACE(path.filename().string());
    EXPECT_EQ(contents(path).times, times);
    for (int time = 0; time < kTimes; ++time) {
      const Volume volume = read_volume(path, {.choice = {.time = time}});
      EXPECT_EQ(volume.dims, kDims);
      EXPECT_EQ(volume.spacing, (Vec3{1, 2, 3}));
      const auto& samples = std::get<std::vector<std::int16_t>>(volume.samples);
      EXPECT_EQ(std::vector<double>(samples.begin(), samples.end()), values_at(time)) << time;
    }
    expect_contains(refusal(path, {}), "3 volumes, one for each time. Choose one with --time");
    expect_contains(refusal(path, {.time = 3}), "it has no time 3. Choose 0 to 2");
    expect_contains(refusal(path, {.time = -1}), "it has no time -1");
  }
  static std::string refusal(const fs::path& path, const VolumeChoice& choice) {
    try {
      (void)read_volume(path, {.choice = choice});
      return "";
    } catch (const VolumeFileError& error) {
      return error.what();
    }
  }

  TemporaryFolder folder_;
};

// Fields as VTK and VisIt write them: between DATASET and DIMENSIONS, numbers as text or
// big-endian.
TEST_F(SeriesFiles, LegacyVtkFilesHaveATime) {
  const auto times_with = [&](std::string_view format, const std::string& field,
                              const std::string& samples) {
    std::string text = legacy_vtk(format, "short", samples);
    text.insert(text.find("DIMENSIONS"), "FIELD FieldData 1\n" + field);
    return contents(file("a.vtk", text)).times.at;
  };
  const std::string binary = packed<std::int16_t>(values_at(0), Endian::kBig);
  std::string text;
  for (const double value : values_at(0)) text += std::to_string(static_cast<int>(value)) + " ";
  EXPECT_EQ(times_with("ASCII", "TimeValue 1 1 double\n0.25\n", text), std::vector{0.25});
  EXPECT_EQ(times_with("BINARY", "TIME 1 1 double\n" + packed<double>({2.5}, Endian::kBig) + "\n",
                       binary),
            std::vector{2.5});
  EXPECT_EQ(
      times_with("BINARY", "TIME 1 1 float\n" + packed<float>({2.5}, Endian::kBig) + "\n", binary),
      std::vector{2.5});
  EXPECT_TRUE(times_with("ASCII", "CYCLE 1 1 int\n7\n", text).empty());
  EXPECT_TRUE(times_with("ASCII", "TimeValue 1 1 double\nnan\n", text).empty());
  EXPECT_TRUE(times_with("ASCII", "TimeValue 1 1 string\na\n", text).empty());
}

TEST_F(SeriesFiles, ReadTimesLastOrFirstFromNrrd) {
  const std::string all = all_times();
  const SourceTimes frames{.count = 3};
  const SourceTimes quarters{.count = 3, .at = {5, 5.25, 5.5}, .unit = "ms"};
  const std::string spaced = kFour + "sizes: 4 3 2 3\nspacings: 1 2 3 0.25\n" +
                             "axis mins: 0 0 0 5\nunits: \"\" \"\" \"\" \"ms\"\n";
  expect_times(file("raw.nrrd", nrrd(kInSpace + "encoding: raw\n", all)), frames);
  expect_times(file("gzip.nrrd", nrrd(kInSpace + "encoding: gzip\n", deflated(all, true))), frames);
  expect_times(file("spaced.nrrd", nrrd(spaced + "encoding: raw\n", all)), quarters);
  expect_times(file("end.nrrd", nrrd(spaced + "encoding: raw\nbyte skip: -1\n", "junk" + all)),
               quarters);
  for (int time = 0; time < kTimes; ++time) {
    file("v" + std::to_string(time) + ".raw", "ab" + shorts_at(time));
  }
  const std::string beside = "NRRD0004\n" + spaced + "encoding: raw\nbyte skip: 2\n";
  expect_times(file("list.nhdr", beside + "data file: LIST 3\nv0.raw\nv1.raw\nv2.raw\n"), quarters);
  expect_times(file("numbered.nhdr", beside + "datafile: v%d.raw 0 2 1 3\n"), quarters);
  std::string text;
  for (int time = 0; time < kTimes; ++time) {
    for (const double value : values_at(time))
      text += std::to_string(static_cast<int>(value)) + " ";
  }
  expect_times(file("text.nrrd", nrrd(kInSpace + "encoding: text\n", text)), frames);
  // The layout of 3D Slicer's sequences.
  expect_times(
      file("slicer.nrrd",
           nrrd(kFour + "space: left-posterior-superior\nsizes: 3 4 3 2\nkinds: list domain domain "
                        "domain\nspace directions: none (1,0,0) (0,2,0) (0,0,3)\n"
                        "space origin: (0,0,0)\nencoding: gzip\naxis 0 index type:=numeric\n"
                        "axis 0 index values:=0 0.5 2\naxis 0 index unit:=sec\n",
                deflated(interleaved(), true))),
      {.count = 3, .at = {0, 0.5, 2}, .unit = "s"});
}

TEST_F(SeriesFiles, KeepThePlacementOfNrrd) {
  const Volume volume = read_volume(
      file("raw.nrrd", nrrd(kInSpace + "encoding: raw\n", all_times())), {.choice = {.time = 1}});
  EXPECT_EQ(volume.meaning.space, WorldSpace::kLps);
  EXPECT_EQ(volume.index_to_world.translation, (Vec3{10, 20, 30}));
}

TEST_F(SeriesFiles, ReadNoSeriesFromNrrdComponents) {
  const std::string components = nrrd(
      kFour + "sizes: 3 4 3 2\nkinds: list domain domain domain\nencoding: raw\n", interleaved());
  const fs::path path = file("components.nrrd", components);
  const Volume volume = read_volume(path, {.choice = {.component = *ComponentChoice::from("2")}});
  EXPECT_EQ(std::get<std::vector<std::int16_t>>(volume.samples)[0], 2007);
}

TEST_F(SeriesFiles, RejectUnsupportedNrrd) {
  expect_contains(
      refusal(file("text.nrrd", nrrd(kInSpace + "encoding: ascii\n", "1 2 3")), {.time = 1}),
      "after 3 numbers it ends");
  expect_contains(
      refusal(file("short.nrrd", nrrd(kInSpace + "encoding: raw\n", all_times().substr(0, 140))),
              {.time = 2}),
      "ends too early");
  expect_contains(refusal(file("cut.nrrd", nrrd(kInSpace + "encoding: gzip\n",
                                                deflated(all_times(), true).substr(0, 60))),
                          {.time = 2}),
                  "cut.nrrd");
  file("v0.raw", shorts_at(0));
  expect_contains(refusal(file("list.nhdr", "NRRD0004\n" + kFour +
                                                "sizes: 4 3 2 3\nencoding: raw\n"
                                                "data file: LIST 3\nv0.raw\nv0.raw\n"),
                          {.time = 1}),
                  "2 data files for 3 parts");
}

TEST_F(SeriesFiles, ReadTimesLastFromMetaImage) {
  const auto header = [](const std::string& more) {
    return "ObjectType = Image\nNDims = 4\nBinaryData = True\nBinaryDataByteOrderMSB = False\n" +
           more +
           "Offset = 10 20 30 5\nElementSpacing = 1 2 3 0.5\nDimSize = 4 3 2 3\n"
           "ElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  };
  const SourceTimes halves{.count = 3, .at = {5, 5.5, 6}};
  expect_times(file("plain.mha", header("") + all_times()), halves);
  const std::string small = deflated(all_times(), false);
  expect_times(file("zlib.mha", header("CompressedData = True\nCompressedDataSize = " +
                                       std::to_string(small.size()) + "\n") +
                                    small),
               halves);
}

TEST_F(SeriesFiles, ReadTimesAndUnitFromNifti) {
  std::string bytes = nifti({4, 16}, all_times(), Endian::kLittle, {1, 0}, {3, 1});
  const auto put = [&](std::size_t at, float value) {
    bytes.replace(at, 4, packed<float>({static_cast<double>(value)}));
  };
  expect_times(file("one.nii", bytes), {.count = 3, .at = {0, 1, 2}});
  put(76 + 16, 0.25F);  // pixdim[4]
  put(136, 2);          // toffset
  bytes[123] = 2 | 16;  // Millimeters, milliseconds.
  expect_times(file("times.nii.gz", deflated(bytes, true)),
               {.count = 3, .at = {2, 2.25, 2.5}, .unit = "ms"});
  put(76 + 16, 0);
  expect_times(file("none.nii", bytes), {.count = 3});
}

TEST_F(SeriesFiles, ReadFieldsFromVti) {
  const auto array = [](const std::string& name, const std::string& components) {
    return "<DataArray type=\"UInt8\" Name=\"" + name + "\" NumberOfComponents=\"" + components +
           "\" format=\"ascii\">1 2 3 4 5 6 7 8 9 1 2 3 4 5 6 7 8 9 1 2 3 4 5 6</DataArray>";
  };
  const fs::path path =
      file("two.vti",
           "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\"><Piece Extent=\"0 1 "
           "0 1 0 "
           "1\"><PointData>" +
               array("pressure", "1") + array("velocity", "3") + "</PointData><CellData>" +
               array("cells", "1") + "</CellData></Piece></ImageData></VTKFile>");
  EXPECT_EQ(contents(path).fields,
            (std::vector<SourceField>{{.name = "pressure", .array = "pressure"},
                                      {.name = "velocity", .array = "velocity", .components = 3}}));
}

TEST_F(SeriesFiles, ReadOrRejectChangedHeaders) {
  std::mt19937 random(2);
  const std::vector<std::pair<std::string, std::string>> whole = {
      {"a.nrrd", nrrd(kInSpace + "encoding: raw\n", all_times())},
      {"b.nrrd", nrrd(kInSpace + "encoding: gzip\n", deflated(all_times(), true))}};
  for (const auto& [name, bytes] : whole) {
    const std::size_t header = bytes.find("\n\n");
    for (int i = 0; i < 60; ++i) {
      std::string changed = bytes;
      for (auto n = 1 + random() % 3; n > 0; --n) {
        changed[9 + random() % (header - 9)] = "0123456789 ()-\"nx\n"[random() % 18];
      }
      const std::string problem =
          refusal(file(name, changed), {.time = static_cast<int>(random() % 3)});
      if (!problem.empty()) expect_contains(problem, "Cannot read '");
    }
  }
}

}  // namespace
}  // namespace multitetra

#include "server/volume/volume_files.hpp"

#include <bzlib.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "server/volume/generators/written_nrrd.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

const std::string kNrrdLines = "dimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: little\n";

std::vector<double> samples_of(const Volume& volume) {
  return std::visit(
      [](const auto& samples) { return std::vector<double>(samples.begin(), samples.end()); },
      volume.samples);
}

// Returns the message of the VolumeFileError that reading `file` throws.
std::string error_of_reading(const fs::path& file, const VolumeFileOptions& options = {}) {
  try {
    (void)read_volume(file, options);
  } catch (const VolumeFileError& error) {
    EXPECT_NE(std::string(error.what()).find(file.stem().string()), std::string::npos)
        << "The error does not name the file: " << error.what();
    return error.what();
  }
  ADD_FAILURE() << file << " was read and should not have been";
  return {};
}

void expect_is_the_volume(const Volume& volume, SampleType type) {
  EXPECT_EQ(volume.dims, kDims);
  EXPECT_EQ(volume.type(), type);
  EXPECT_EQ(samples_of(volume), values());
}

class VolumeFiles : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
};

// ---- each format

TEST_F(VolumeFiles, KeepEverySampleTypeOfNrrd) {
  const auto read = [&](const std::string& type, const std::string& samples) {
    return read_volume(folder_.file("v.nrrd", nrrd(kNrrdLines + "type: " + type + "\n", samples)));
  };
  expect_is_the_volume(read("uint8", packed<std::uint8_t>(values())), SampleType::kU8);
  expect_is_the_volume(read("uint16", packed<std::uint16_t>(values())), SampleType::kU16);
  expect_is_the_volume(read("int16", packed<std::int16_t>(values())), SampleType::kI16);
  expect_is_the_volume(read("float", packed<float>(values())), SampleType::kF32);
  const Volume bytes = read("int8", std::string(24, '\x80'));
  EXPECT_EQ(bytes.type(), SampleType::kI8);
  EXPECT_EQ(samples_of(bytes), std::vector<double>(24, -128));
}

TEST_F(VolumeFiles, ReadBigEndianNrrd) {
  const std::string lines =
      "type: uint16\ndimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: big\n";
  expect_is_the_volume(read_volume(folder_.file(
                           "v.nrrd", nrrd(lines, packed<std::uint16_t>(values(), Endian::kBig)))),
                       SampleType::kU16);
}

TEST_F(VolumeFiles, ConvertUnsupportedTypesToFloatWithANotice) {
  const auto check = [&](const std::string& type, const std::string& samples) {
    std::vector<std::string> notices;
    const Volume volume = read_volume(
        folder_.file("v.nrrd", nrrd(kNrrdLines + "spacings: 1 1 1\ntype: " + type + "\n", samples)),
        {.notice = [&](const std::string& text) { notices.push_back(text); }});
    expect_is_the_volume(volume, SampleType::kF32);
    ASSERT_EQ(notices.size(), 1u) << type;
    expect_contains(notices[0], "become f32");
  };
  check("int32", packed<std::int32_t>(values()));
  check("uint32", packed<std::uint32_t>(values()));
  check("int64", packed<std::int64_t>(values()));
  check("uint64", packed<std::uint64_t>(values()));
  check("double", packed<double>(values()));
}

TEST_F(VolumeFiles, RefuseDoublesWhoseDifferencesFloatsLose) {
  // The radius of the Moon in metres, and a relief of 0.2.
  std::vector<double> numbers = values();
  for (double& number : numbers) number = 1'737'400 + (number - 10) / 50;
  const auto file = folder_.file(
      "v.nrrd", nrrd(kNrrdLines + "spacings: 1 1 1\ntype: double\n", packed<double>(numbers)));
  try {
    (void)read_volume(file);
    ADD_FAILURE();
  } catch (const VolumeFileError& error) {
    expect_contains(error.what(), " % of their range");
    expect_contains(error.what(), "--subtract 1737400,");
    expect_contains(error.what(), "--allow-loss");
  }
  const Volume differences = read_volume(file, {.choice = {.subtract = 1'737'400}});
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(samples_of(differences)[i], static_cast<float>(numbers[i] - 1'737'400));
  }
  std::vector<std::string> notices;
  const Volume rounded =
      read_volume(file, {.choice = {.allow_loss = true},
                         .notice = [&](const std::string& text) { notices.push_back(text); }});
  EXPECT_EQ(samples_of(rounded)[0], static_cast<float>(numbers[0]));
  EXPECT_EQ(rounded.meaning.rounding.find("up to 0.06"), 0U) << rounded.meaning.rounding;
  EXPECT_EQ(differences.meaning.rounding, "");
  const Volume constant = read_volume(
      folder_.file("c.nrrd", nrrd(kNrrdLines + "spacings: 1 1 1\ntype: double\n",
                                  packed<double>(std::vector<double>(numbers.size(), 0.1)))));
  EXPECT_EQ(constant.meaning.rounding, "") << "no surface moves";
  ASSERT_EQ(notices.size(), 1U);
  expect_contains(notices[0], " % of their range)");
}

TEST_F(VolumeFiles, RefuseDoublesBeyondFloats) {
  const auto file = folder_.file("v.nrrd", nrrd(kNrrdLines + "spacings: 1 1 1\ntype: double\n",
                                                packed<double>(std::vector<double>(24, 1e300))));
  try {
    (void)read_volume(file);
    ADD_FAILURE();
  } catch (const VolumeFileError& error) {
    expect_contains(error.what(), "beyond 3.4e38");
  }
  // Several values are data, one is a mark.
  std::vector<double> numbers = values();
  numbers[6] = 1e300;
  numbers[7] = 2e300;
  const auto two = folder_.file(
      "w.nrrd", nrrd(kNrrdLines + "spacings: 1 1 1\ntype: double\n", packed<double>(numbers)));
  try {
    (void)read_volume(two);
    ADD_FAILURE();
  } catch (const VolumeFileError& error) {
    expect_contains(error.what(), "2 of its samples of type f64 are beyond 3.4e38");
    expect_contains(error.what(), "--allow-loss");
  }
  EXPECT_TRUE(std::isnan(samples_of(read_volume(two, {.choice = {.allow_loss = true}}))[7]));
  numbers = values();
  for (double& number : numbers) number *= 1e-300;
  try {
    (void)read_volume(folder_.file(
        "x.nrrd", nrrd(kNrrdLines + "spacings: 1 1 1\ntype: double\n", packed<double>(numbers))));
    ADD_FAILURE();
  } catch (const VolumeFileError& error) {
    expect_contains(error.what(), "Scale them up");
  }
}

// Nanoseconds of one second: doubles, and the differences of doubles, hold only steps of 256.
TEST_F(VolumeFiles, SubtractFromWideIntegersExactly) {
  constexpr std::int64_t kBase = 1'700'000'000'000'000'000;
  std::vector<std::int64_t> numbers;
  for (const double value : values()) numbers.push_back(kBase + static_cast<std::int64_t>(value));
  const Volume volume = read_volume(
      folder_.file("v.nrrd",
                   nrrd(kNrrdLines + "spacings: 1 1 1\ntype: int64\n",
                        {reinterpret_cast<const char*>(numbers.data()), 8 * numbers.size()})),
      {.choice = {.subtract = static_cast<double>(kBase)}});
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(samples_of(volume)[i], static_cast<float>(numbers[i] - kBase));
  }
}

TEST_F(VolumeFiles, KeepNanAndConvertInfinityToVoid) {
  std::vector<double> numbers = values();
  numbers[3] = std::numeric_limits<double>::quiet_NaN();
  numbers[5] = std::numeric_limits<double>::infinity();
  numbers[6] = 1e300;  // Beyond the range of floats.
  std::vector<std::string> notices;
  const Volume volume = read_volume(
      folder_.file("v.nrrd",
                   nrrd(kNrrdLines + "spacings: 1 1 1\ntype: double\n", packed<double>(numbers))),
      {.notice = [&](const std::string& text) { notices.push_back(text); }});
  const std::vector<double> read = samples_of(volume);
  for (const std::size_t i : {3u, 5u, 6u}) EXPECT_TRUE(std::isnan(read[i])) << i;
  EXPECT_EQ(read[4], numbers[4]);
  ASSERT_EQ(notices.size(), 2u);
  expect_contains(notices[1], "2 samples");
}

TEST_F(VolumeFiles, FindSlicesOfDetachedNrrdByPatternAndList) {
  const std::string all = packed<std::uint8_t>(values());
  folder_.file("slice.1", all.substr(0, 12));
  folder_.file("slice.2", all.substr(12));
  const std::string lines = kNrrdLines + "type: uint8\ndata file: ";
  expect_is_the_volume(
      read_volume(folder_.file("pattern.nhdr", "NRRD0004\n" + lines + "slice.%d 1 2 1\n")),
      SampleType::kU8);
  expect_is_the_volume(
      read_volume(folder_.file("list.nhdr", "NRRD0004\n" + lines + "LIST\nslice.1\nslice.2\n")),
      SampleType::kU8);
}

TEST_F(VolumeFiles, ReadNrrdFieldsInAnyOrder) {
  const std::string samples = packed<std::uint8_t>(values());
  const Volume spacings = read_volume(folder_.file(
      "spacings.nrrd",
      nrrd(kNrrdLines + "type: uint8\nspacings: 1 2 3\nspace: left-posterior-superior\n",
           samples)));
  expect_is_the_volume(spacings, SampleType::kU8);
  EXPECT_EQ(spacings.spacing, (Vec3{1, 2, 3}));
  const Volume late = read_volume(folder_.file(
      "late.nrrd", nrrd(kNrrdLines + "type: uint8\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n"
                                     "space origin: (10,20,30)\n",
                        samples)));
  expect_is_the_volume(late, SampleType::kU8);
  EXPECT_EQ(late.spacing, (Vec3{1, 2, 3}));
  EXPECT_EQ(late.index_to_world.translation, (Vec3{10, 20, 30}));
}

TEST_F(VolumeFiles, ReadMetaImageWithLocalDetachedAndCompressedData) {
  const std::string samples = packed<std::int16_t>(values());
  const Volume inside =
      read_volume(folder_.file("a.mha", meta_image_header("MET_SHORT", "LOCAL") + samples));
  expect_is_the_volume(inside, SampleType::kI16);
  EXPECT_EQ(inside.spacing, (Vec3{1, 2, 3}));
  EXPECT_EQ(inside.index_to_world({1, 1, 1}), (Vec3{11, 22, 33}));

  folder_.file("b.raw", samples);
  expect_is_the_volume(read_volume(folder_.file("b.mhd", meta_image_header("MET_SHORT", "b.raw"))),
                       SampleType::kI16);

  const std::string small = deflated(samples, false);
  const std::string lines =
      "CompressedData = True\nCompressedDataSize = " + std::to_string(small.size()) + "\n";
  expect_is_the_volume(
      read_volume(folder_.file("c.mha", meta_image_header("MET_SHORT", "LOCAL", lines) + small)),
      SampleType::kI16);
  folder_.file("d.zraw", small);
  expect_is_the_volume(
      read_volume(folder_.file("d.mhd", meta_image_header("MET_SHORT", "d.zraw", lines))),
      SampleType::kI16);
}

TEST_F(VolumeFiles, ReadNiftiInBothByteOrdersAndConvertToLps) {
  for (const Endian endian : {Endian::kLittle, Endian::kBig}) {
    const std::string bytes = nifti({4, 16}, packed<std::int16_t>(values(), endian), endian);
    const Volume volume = read_volume(folder_.file("v.nii", bytes));
    expect_is_the_volume(volume, SampleType::kI16);
    EXPECT_EQ(volume.spacing, (Vec3{1, 2, 3}));
    EXPECT_EQ(volume.index_to_world({0, 0, 0}), (Vec3{-10, -20, 30}));
    EXPECT_EQ(volume.index_to_world({1, 1, 1}), (Vec3{-11, -22, 33}));
    expect_is_the_volume(read_volume(folder_.file("v.nii.gz", deflated(bytes, true))),
                         SampleType::kI16);
    const std::string two_members =
        deflated(bytes.substr(0, 200), true) + deflated(bytes.substr(200), true);
    expect_is_the_volume(read_volume(folder_.file("w.nii.gz", two_members)), SampleType::kI16);
  }
}

TEST_F(VolumeFiles, ApplyNiftiSlopeAndIntercept) {
  const Volume volume = read_volume(folder_.file(
      "v.nii", nifti({4, 16}, packed<std::int16_t>(values()), Endian::kLittle, {0.5F, 3})));
  EXPECT_EQ(volume.type(), SampleType::kF32);
  EXPECT_EQ(samples_of(volume)[0], 0.5 * 7 + 3);
  EXPECT_EQ(samples_of(volume)[23], 0.5 * 237 + 3);
}

TEST_F(VolumeFiles, ReadTextAndBinaryLegacyVtk) {
  std::string text;
  for (const double value : values()) text += std::to_string(value) + "\n";
  const Volume ascii = read_volume(folder_.file("a.vtk", legacy_vtk("ASCII", "float", text)));
  expect_is_the_volume(ascii, SampleType::kF32);
  EXPECT_EQ(ascii.spacing, (Vec3{1, 2, 3}));
  EXPECT_EQ(ascii.index_to_world.translation, (Vec3{10, 20, 30}));
  const std::string binary = packed<std::uint16_t>(values(), Endian::kBig);
  expect_is_the_volume(
      read_volume(folder_.file("b.vtk", legacy_vtk("BINARY", "unsigned_short", binary))),
      SampleType::kU16);
}

TEST_F(VolumeFiles, ReadTiffPagesAsSlices) {
  const std::string all = packed<std::uint16_t>(values());
  expect_is_the_volume(
      read_volume(folder_.file("v.tif", tiff({all.substr(0, 24), all.substr(24)}, 2))),
      SampleType::kU16);
}

TEST_F(VolumeFiles, ReadTiffStacksInNaturalOrder) {
  const std::string all = packed<std::uint8_t>(values());
  folder_.file("stack/slice10.tif", tiff({all.substr(12)}, 1));
  folder_.file("stack/slice9.tif", tiff({all.substr(0, 12)}, 1));
  folder_.file("stack/readme.txt", "not an image");
  for (const char* pattern : {"stack", "stack/slice*.tif", "stack/slice%d.tif", "stack/*.tif"}) {
    SCOPED_TRACE(pattern);
    expect_is_the_volume(read_volume(folder_.path() / pattern), SampleType::kU8);
  }
}

TEST_F(VolumeFiles, ReadOneImageAsOneSlice) {
  const Volume volume = read_volume(folder_.file("v.tif", tiff({std::string(12, '\x05')}, 1)));
  EXPECT_EQ(volume.dims, (std::array<std::int32_t, 3>{4, 3, 1}));
  EXPECT_EQ(samples_of(volume), std::vector<double>(12, 5));
}

TEST_F(VolumeFiles, ReadRawBytesInBothByteOrdersAfterAHeader) {
  for (const Endian endian : {Endian::kLittle, Endian::kBig}) {
    const fs::path file = folder_.file("v.raw", "header" + packed<std::uint16_t>(values(), endian));
    const Volume volume = read_volume(file, {.raw = RawLayout{.dims = kDims,
                                                              .type = StoredType::kU16,
                                                              .endian = endian,
                                                              .header_bytes = 6},
                                             .placement = {.spacing = Vec3{1, 2, 3}}});
    expect_is_the_volume(volume, SampleType::kU16);
    EXPECT_EQ(volume.index_to_world({1, 1, 1}), (Vec3{1, 2, 3}));
  }
}

TEST_F(VolumeFiles, RoundTripNrrdExactly) {
  Volume volume = {.dims = kDims, .spacing = {0.1, 0.7, 3}, .index_to_world = {}, .samples = {}};
  volume.index_to_world = {.columns = {Vec3{0, 0.1, 0}, Vec3{-0.7, 0, 0}, Vec3{0, 0, 3}},
                           .translation = {1.1, -2.2, 3.3}};
  const auto check = [&](auto samples) {
    volume.samples = samples;
    const fs::path file = folder_.path() / "out.nrrd";
    write_nrrd(file, *source_of(volume));
    const Volume read = read_volume(file);
    EXPECT_EQ(read.dims, volume.dims);
    EXPECT_EQ(read.samples, volume.samples);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_DOUBLE_EQ(read.spacing[axis], volume.spacing[axis]);
      for (std::size_t row = 0; row < 3; ++row) {
        EXPECT_NEAR(read.index_to_world.columns[axis][row],
                    volume.index_to_world.columns[axis][row], 1e-15);
      }
      EXPECT_DOUBLE_EQ(read.index_to_world.translation[axis],
                       volume.index_to_world.translation[axis]);
    }
  };
  check(std::vector<std::uint8_t>(24, 255));
  check(std::vector<std::int8_t>(24, -128));
  check(std::vector<std::uint16_t>(24, 65535));
  check(std::vector<std::int16_t>(24, -32768));
  check(std::vector<float>(24, -1.0F / 3.0F));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1)
      << "A temporary file was left behind.";
}

// ---- unreadable files

TEST_F(VolumeFiles, NameARemedyForMissingFilesAndUnknownSuffixes) {
  expect_contains(error_of_reading(folder_.path() / "none.nrrd"), "the file does not exist");
  const std::string unknown = error_of_reading(folder_.file("v.dat", "bytes"));
  for (const char* suffix : {".nrrd", ".nhdr", ".mha", ".mhd", ".nii.gz", ".vtk", ".tif"}) {
    expect_contains(unknown, suffix);
  }
  expect_contains(error_of_reading(folder_.file("v.vti", "<VTKFile>")), "ImageData");
  expect_contains(error_of_reading(folder_.path()), "TIFF");
}

TEST_F(VolumeFiles, NameExpectedAndActualCountsOfRawBytes) {
  const fs::path file = folder_.file("v.raw", std::string(30, 'x'));
  const std::string error =
      error_of_reading(file, {.raw = RawLayout{.dims = kDims, .header_bytes = 5}});
  expect_contains(error, "30 bytes");
  expect_contains(error, "5 for the header and 24 for the samples");
  error_of_reading(file, {.raw = RawLayout{.dims = {0, 3, 2}}});
  error_of_reading(file, {.raw = RawLayout{.dims = {-1, 3, 2}}});
  error_of_reading(file, {.raw = RawLayout{.dims = {16386, 1, 1}}});
  error_of_reading(file, {.raw = RawLayout{.dims = {5, 3, 2}, .header_bytes = 31}});
}

TEST_F(VolumeFiles, RejectTruncatedFiles) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string nii = nifti({4, 16}, shorts, Endian::kLittle);
  std::string text;
  for (const double value : values()) text += std::to_string(value) + "\n";
  const std::string packed_shorts = deflated(shorts, false);
  const std::string compressed =
      "CompressedData = True\nCompressedDataSize = " + std::to_string(packed_shorts.size()) + "\n";
  const std::string beside = "beside.raw";
  folder_.file(beside, shorts.substr(0, 47));
  error_of_reading(folder_.file("beside.mhd", meta_image_header("MET_SHORT", beside)));

  const std::vector<std::pair<std::string, std::string>> whole = {
      {"v.nrrd", nrrd(kNrrdLines + "type: int16\n", shorts)},
      {"v.mha", meta_image_header("MET_SHORT", "LOCAL") + shorts},
      {"z.mha", meta_image_header("MET_SHORT", "LOCAL", compressed) + packed_shorts},
      {"v.nii", nii},
      {"v.nii.gz", deflated(nii, true)},
      {"a.vtk", legacy_vtk("ASCII", "float", text)},
      {"b.vtk", legacy_vtk("BINARY", "short", packed<std::int16_t>(values(), Endian::kBig))},
      {"v.tif", tiff({shorts.substr(0, 24), shorts.substr(24)}, 2)},
  };
  for (const auto& [name, bytes] : whole) {
    SCOPED_TRACE(name);
    EXPECT_EQ(read_volume(folder_.file(name, bytes)).dims, kDims);
    const std::size_t last_number = name == "a.vtk" ? text.size() / 24 + 2 : 1;
    for (const std::size_t missing : {last_number, std::size_t{20}, std::size_t{47}}) {
      SCOPED_TRACE(missing);
      error_of_reading(folder_.file(name, bytes.substr(0, bytes.size() - missing)));
    }
    for (std::size_t size = 0; size < bytes.size() - 48; size += 29) {
      SCOPED_TRACE(size);
      error_of_reading(folder_.file(name, bytes.substr(0, size)));
    }
  }
}

TEST_F(VolumeFiles, CheckPackedSamplesToTheEndOfTheirStream) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string lines = "dimension: 3\nsizes: 4 3 2\nendian: little\ntype: int16\nencoding: ";
  std::string bzip2(1000, '\0');
  auto size = static_cast<unsigned>(bzip2.size());
  std::string source = shorts;
  ASSERT_EQ(BZ2_bzBuffToBuffCompress(bzip2.data(), &size, source.data(),
                                     static_cast<unsigned>(source.size()), 1, 0, 0),
            BZ_OK);
  bzip2.resize(size);
  for (const auto& [encoding, stream] :
       {std::pair("gzip", deflated(shorts, true)), {"bzip2", bzip2}}) {
    SCOPED_TRACE(encoding);
    const auto read = [&, header = lines + encoding + "\n"](const std::string& changed) {
      return samples_of(read_volume(folder_.file("packed.nrrd", nrrd(header, changed))));
    };
    EXPECT_EQ(read(stream), values());
    for (std::size_t bit = 0; bit < 8 * stream.size(); bit += 11) {
      std::string changed = stream;
      changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
      try {
        EXPECT_EQ(read(changed), values()) << "bit " << bit;
      } catch (const VolumeFileError&) {  // Expected: few changed bits are insignificant.
      }
    }
  }
}

TEST_F(VolumeFiles, RejectVectorsAndSeveralTimes) {
  const std::string rgb =
      "dimension: 4\nsizes: 3 4 3 2\nkinds: RGB-color domain domain domain\n"
      "encoding: raw\ntype: uint8\n";
  expect_contains(error_of_reading(folder_.file("rgb.nrrd", nrrd(rgb, std::string(72, 'x')))),
                  "3 components");
  const std::string twice = packed<std::int16_t>(values()) + packed<std::int16_t>(values());
  expect_contains(error_of_reading(folder_.file(
                      "two.nii", nifti({4, 16}, twice, Endian::kLittle, {1, 0}, {2, 1}))),
                  "--time");
}

TEST_F(VolumeFiles, RejectExcessiveSizesBeforeAllocating) {
  const auto header = [&](const std::string& sizes) {
    return nrrd("type: double\ndimension: 3\nencoding: text\nsizes: " + sizes + "\n", "1 2");
  };
  expect_contains(error_of_reading(folder_.file("wide.nrrd", header("16386 1 1"))), "16385");
  expect_contains(error_of_reading(folder_.file("deep.nrrd", header("4097 4097 4097"))), "memory");
}

TEST_F(VolumeFiles, RejectUnusedOptions) {
  const fs::path file =
      folder_.file("v.nrrd", nrrd(kNrrdLines + "type: uint8\n", packed<std::uint8_t>(values())));
  const auto refusal = [&](const VolumeChoice& choice) {
    return error_of_reading(file, {.choice = choice});
  };
  expect_contains(refusal({.array = "foo"}),
                  "--array does not apply: the file has no named arrays");
  expect_contains(refusal({.level = 1}), "--level does not apply");
  expect_contains(refusal({.time = 3}), "--time does not apply: the file has no times");
  expect_contains(refusal({.channel = 3}),
                  "the file has no channels, only one volume of 4 x 3 x 2 samples. Omit --channel");
  expect_contains(refusal({.series = "2"}), "--series does not apply");
  for (const char* component : {"1", "magnitude", "luminance"}) {
    expect_contains(refusal({.component = ComponentChoice::from(component).value()}),
                    "no components");
  }
  EXPECT_EQ(read_volume(file, {.choice = {.time = 0}}).dims, kDims);
  const fs::path points = folder_.file("v.vtk", legacy_vtk("BINARY", "char", std::string(24, 'x')));
  expect_contains(error_of_reading(points, {.choice = {.time = 1}}), "the file has no times");
}

TEST_F(VolumeFiles, RejectDifferingImagesOfAStackByName) {
  folder_.file("stack/a.tif", tiff({std::string(12, 'x')}, 1));
  folder_.file("stack/b.tif", tiff({std::string(15, 'x')}, 1, 5));
  try {
    (void)read_volume(folder_.path() / "stack");
    FAIL() << "The stack was read.";
  } catch (const VolumeFileError& error) {
    expect_contains(error.what(), "b.tif");
    expect_contains(error.what(), "5 x 3 x 1");
  }
}

}  // namespace
}  // namespace multitetra

#include "server/volume/volume_source.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "server/volume/generators/written_nrrd.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Samples as text, so that NaN equals itself.
std::vector<std::string> words_of(const Samples& samples) {
  std::vector<std::string> words;
  std::visit(
      [&](const auto& values) {
        for (const auto value : values) words.push_back(std::to_string(value));
      },
      samples);
  return words;
}

std::string lines(const std::string& type, const std::string& more) {
  return "type: " + type + "\ndimension: 3\nsizes: 4 3 2\n" + more;
}

std::string in_hex(const std::string& bytes) {
  std::string digits;
  for (const char byte : bytes) {
    digits += "0123456789abcdef"[static_cast<unsigned char>(byte) >> 4];
    digits += "0123456789ABCDEF"[byte & 15];
    if (digits.size() % 7 == 0) digits += '\n';
  }
  return digits;
}

struct WrittenVolume {
  fs::path path;
  VolumeFileOptions options = {};
};

class VolumeSources : public ::testing::Test {
 protected:
  // A volume in every format that the tests can write, with distinct slices.
  std::vector<WrittenVolume> all_formats();

  fs::path nrrd_file(const std::string& name, const std::string& type, const std::string& more,
                     const std::string& samples) {
    return folder_.file(name, nrrd(lines(type, more), samples));
  }
  fs::path nhdr_file(const std::string& name, const std::string& type, const std::string& more) {
    return folder_.file(name, "NRRD0005\n" + lines(type, more));
  }

  TemporaryFolder folder_;
};

std::vector<WrittenVolume> VolumeSources::all_formats() {
  const std::string bytes = packed<std::uint8_t>(values());
  const std::string shorts = packed<std::int16_t>(values());
  const std::string big_shorts = packed<std::int16_t>(values(), Endian::kBig);
  const std::string floats = packed<float>(values());
  std::string text;
  for (const double value : values()) text += std::to_string(static_cast<int>(value)) + "\n";
  std::vector<double> odd = values();
  odd[2] = std::numeric_limits<double>::infinity();
  odd[20] = std::numeric_limits<double>::quiet_NaN();

  folder_.file("all.raw", "two\nlines\nskip" + shorts + "tail");
  folder_.file("end.raw", "something" + shorts);
  folder_.file("part.008", "\nx" + shorts.substr(0, 24));
  folder_.file("part.010", "\nx" + shorts.substr(24));
  folder_.file("with space.raw", shorts);
  folder_.file("meta.raw", "header" + big_shorts);
  folder_.file("stack/b1.tif", tiff({shorts.substr(0, 24)}, 2));
  folder_.file("stack/b2.tif", tiff({shorts.substr(24)}, 2));
  folder_.file("part.gz", deflated(shorts.substr(0, 24), true));
  folder_.file("last.gz", deflated(shorts.substr(24), true));
  for (const char* name : {"first.raw", "cut1.raw"}) folder_.file(name, shorts.substr(0, 24));
  for (const char* name : {"last.raw", "cut2.raw"}) folder_.file(name, shorts.substr(24));
  std::string text_header = meta_image_header("MET_SHORT", "LOCAL");
  text_header.replace(text_header.find("BinaryData = True"), 17, "BinaryData = False");
  const std::string small = deflated(shorts, false);
  const std::string zipped =
      "CompressedData = True\nCompressedDataSize = " + std::to_string(small.size()) + "\n";
  std::string big_endian_header = meta_image_header("MET_SHORT", "meta.raw", "HeaderSize = 6\n");
  const std::string little_line = "BinaryDataByteOrderMSB = False";
  big_endian_header.replace(big_endian_header.find(little_line), little_line.size(),
                            "ElementByteOrderMSB = True");
  const std::string little = "encoding: raw\nendian: little\n";
  const std::string skips = little + "line skip: 1\nbyte skip: 1\n";

  std::vector<WrittenVolume> result = {
      {nrrd_file("u8.nrrd", "uint8", "encoding: raw\n", bytes)},
      {nrrd_file("i16.nrrd", "short", "# a comment\nkey:=value: x\n" + little, shorts)},
      {nrrd_file("big.nrrd", "int16", "Encoding: RAW\nendian: big\n", big_shorts)},
      {nrrd_file("f32.nrrd", "float", little, floats)},
      {nrrd_file("i32.nrrd", "int32", little, packed<std::int32_t>(values()))},
      {nrrd_file("u64.nrrd", "uint64", little, packed<std::uint64_t>(values()))},
      {nrrd_file("f64.nrrd", "double", little, packed<double>(odd))},
      {nrrd_file("inf.nrrd", "float", little, packed<float>(odd))},
      {nrrd_file("late.nrrd", "short", little + "space directions: (1,0,0) (0,2,0) (0,0,3)\n",
                 shorts)},
      {nrrd_file("text.nrrd", "short", "encoding: ascii\n", text)},
      {nrrd_file("hex.nrrd", "short", "encoding: hex\nendian: little\n", in_hex(shorts))},
      {nrrd_file("gzip.nrrd", "short", "encoding: gzip\nendian: little\n", deflated(shorts, true))},
      {nhdr_file("all.nhdr", "short", little + "line skip: 2\nbyte skip: 4\ndata file: all.raw\n")},
      {nhdr_file("end.nhdr", "short", little + "byteskip: -1\ndatafile: end.raw\n")},
      {nhdr_file("space.nhdr", "short", little + "data file: with space.raw\n")},
      {nhdr_file("pattern.nhdr", "short", skips + "data file: part.%03d 8 10 2\n")},
      {nhdr_file("list.nhdr", "short", skips + "data file: LIST 2\npart.008\npart.010\n")},
      {nhdr_file("zlist.nhdr", "short",
                 "encoding: gzip\nendian: little\ndata file: LIST\npart.gz\nlast.gz\n")},
      {folder_.file("list.mhd", meta_image_header("MET_SHORT", "LIST") + "first.raw\nlast.raw\n")},
      {folder_.file("pattern.mhd", meta_image_header("MET_SHORT", "cut%d.raw 1 2 1"))},
      {folder_.file("text.mha", text_header + text)},
      {folder_.file("in.mha", meta_image_header("MET_SHORT", "LOCAL") + shorts)},
      {folder_.file("big.mhd", big_endian_header)},
      {folder_.file("end.mhd", meta_image_header("MET_SHORT", "end.raw", "HeaderSize = -1\n"))},
      {folder_.file("f64.mha", meta_image_header("MET_DOUBLE", "LOCAL") + packed<double>(odd))},
      {folder_.file("z.mha", meta_image_header("MET_SHORT", "LOCAL", zipped) + small)},
      {folder_.file("v.nii", nifti({4, 16}, shorts, Endian::kLittle))},
      {folder_.file("w.nii.gz", deflated(nifti({4, 16}, big_shorts, Endian::kBig), true))},
      {folder_.file("b.vtk", legacy_vtk("BINARY", "short", big_shorts))},
      {folder_.file("a.vtk", legacy_vtk("ASCII", "short", text))},
      {folder_.file("v.tif", tiff({shorts.substr(0, 24), shorts.substr(24)}, 2))},
      {folder_.path() / "stack"},
      {folder_.path() / "stack/b%d.tif"},
  };
  for (const Endian endian : {Endian::kLittle, Endian::kBig}) {
    const RawLayout layout{
        .dims = kDims, .type = StoredType::kF32, .endian = endian, .header_bytes = 3};
    const std::string name = endian == Endian::kBig ? "big.bin" : "little.bin";
    result.push_back({folder_.file(name, "abc" + packed<float>(odd, endian)), {.raw = layout}});
  }
  return result;
}

TEST_F(VolumeSources, JoinSlabsOfAnySizeToTheVolume) {
  for (const WrittenVolume& written : all_formats()) {
    SCOPED_TRACE(written.path.string());
    const Volume whole = read_volume(written.path, written.options);
    const auto source = open_volume(written.path, written.options);
    EXPECT_EQ(source->header().dims, whole.dims);
    EXPECT_EQ(source->header().type, whole.type());
    EXPECT_EQ(source->header().spacing, whole.spacing);
    EXPECT_EQ(source->header().index_to_world, whole.index_to_world);
    const std::vector<std::string> expected = words_of(whole.samples);
    Samples slab;
    for (const std::int32_t slices : {1, 3, whole.dims[2]}) {
      std::vector<std::string> together;
      for (std::int32_t z = 0; z < whole.dims[2]; z += slices) {
        source->read(z, std::min(slices, whole.dims[2] - z), slab);
        EXPECT_EQ(static_cast<SampleType>(slab.index()), whole.type());
        const std::vector<std::string> words = words_of(slab);
        together.insert(together.end(), words.begin(), words.end());
      }
      EXPECT_EQ(together, expected) << slices << " slices at a time";
    }
    EXPECT_EQ(words_of(source->take_all()), expected);
  }
}

TEST_F(VolumeSources, ReadTheSameSamplesFromEveryFormat) {
  for (const WrittenVolume& written : all_formats()) {
    SCOPED_TRACE(written.path.string());
    const auto samples = words_of(read_volume(written.path, written.options).samples);
    ASSERT_EQ(samples.size(), values().size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const std::string name = written.path.filename().string();
      const bool is_odd = (i == 2 || i == 20) &&
                          (name.starts_with("f64") || name == "inf.nrrd" || name.ends_with(".bin"));
      const double expected = name == "u8.nrrd" ? std::fmod(values()[i], 256) : values()[i];
      if (is_odd) {
        EXPECT_TRUE(std::isnan(std::stod(samples[i]))) << i;
      } else {
        EXPECT_EQ(std::stod(samples[i]), expected) << i;
      }
    }
  }
}

TEST_F(VolumeSources, ReadSlabsInAnyOrderAndRepeatedly) {
  const Volume volume = {.dims = {5, 4, 7},
                         .spacing = {1, 1, 1},
                         .index_to_world = {},
                         .samples = std::vector<std::uint16_t>(140)};
  Volume filled = volume;
  auto& samples = std::get<std::vector<std::uint16_t>>(filled.samples);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<std::uint16_t>(i * 77);
  const fs::path file = folder_.path() / "v.nrrd";
  write_nrrd(file, *source_of(filled));
  const auto from_file = open_volume(file);
  const auto from_memory = source_of(filled);
  for (const auto& [first, slices] : {std::pair{4, 3}, {0, 1}, {6, 1}, {2, 4}, {4, 3}}) {
    const std::vector<std::uint16_t> expected(samples.begin() + 20 * first,
                                              samples.begin() + 20 * (first + slices));
    Samples slab;
    from_file->read(first, slices, slab);
    EXPECT_EQ(slab, Samples(expected));
    from_memory->read(first, slices, slab);
    EXPECT_EQ(slab, Samples(expected));
  }
}

TEST_F(VolumeSources, PrintNoticesOnce) {
  std::vector<double> numbers = values();
  numbers[5] = numbers[20] = std::numeric_limits<double>::infinity();
  std::vector<std::string> notices;
  const auto source =
      open_volume(nrrd_file("v.nrrd", "double", "encoding: raw\nendian: little\nspacings: 1 1 1\n",
                            packed<double>(numbers)),
                  {.notice = [&](const auto& text) { notices.push_back(text); }});
  Samples slab;
  source->read(1, 1, slab);
  source->read(1, 1, slab);
  EXPECT_EQ(notices.size(), 0u);
  for (int i = 0; i < 3; ++i) source->read(0, 2, slab);
  ASSERT_EQ(notices.size(), 2u);
  EXPECT_NE(notices[0].find("f64 become f32, exactly"), std::string::npos) << notices[0];
  EXPECT_NE(notices[1].find("2 samples"), std::string::npos) << notices[1];
}

// ---- damaged files

std::string error_of_opening(const fs::path& file) {
  try {
    (void)open_volume(file);
  } catch (const VolumeFileError& error) {
    return error.what();
  }
  return "opened";
}

TEST_F(VolumeSources, RejectTruncatedFilesWhenOpened) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string little = "encoding: raw\nendian: little\n";
  folder_.file("part.1", shorts.substr(0, 24));
  folder_.file("part.2", shorts.substr(24, 23));
  for (const fs::path& file :
       {nrrd_file("v.nrrd", "short", little, shorts.substr(1)),
        nhdr_file("list.nhdr", "short", little + "data file: LIST\npart.1\npart.2\n"),
        folder_.file("v.mha", meta_image_header("MET_SHORT", "LOCAL") + shorts.substr(1)),
        folder_.file("v.mhd", meta_image_header("MET_SHORT", "part.1", "HeaderSize = -1\n")),
        folder_.file("b.vtk", legacy_vtk("BINARY", "short", shorts.substr(1)))}) {
    EXPECT_NE(error_of_opening(file).find("bytes of samples"), std::string::npos)
        << error_of_opening(file);
  }
  EXPECT_NE(error_of_opening(folder_.path() / "list.nhdr").find("part.2"), std::string::npos);
}

TEST_F(VolumeSources, ReportVanishedAndTruncatedDataFiles) {
  const std::string shorts = packed<std::int16_t>(values());
  const std::string header = "encoding: raw\nendian: little\ndata file: v.raw\n";
  const fs::path file = nhdr_file("v.nhdr", "short", header);
  const fs::path data = folder_.file("v.raw", shorts);
  const auto shrinks = open_volume(file);
  folder_.file("first.raw", shorts.substr(0, 24));
  folder_.file("second.raw", shorts.substr(24));
  const auto vanishes = open_volume(
      nhdr_file("list.nhdr", "short",
                "encoding: raw\nendian: little\ndata file: LIST\nfirst.raw\nsecond.raw\n"));
  fs::resize_file(data, 40);
  Samples slab;
  shrinks->read(0, 1, slab);
  EXPECT_THROW(shrinks->read(1, 1, slab), VolumeFileError);
  fs::remove(folder_.path() / "first.raw");
  EXPECT_THROW(vanishes->read(0, 1, slab), VolumeFileError);
}

TEST_F(VolumeSources, RejectInvalidNrrdDataFiles) {
  const std::string little = "encoding: raw\nendian: little\n";
  folder_.file("v.raw", packed<std::int16_t>(values()));
  for (const char* more :
       {"line skip: 99999999\ndata file: v.raw\n", "byte skip: 9999999999\ndata file: v.raw\n",
        "data file: LIST\n", "data file: .\n", "data file: none.raw\n"}) {
    SCOPED_TRACE(more);
    EXPECT_NE(error_of_opening(nhdr_file("v.nhdr", "short", little + more)), "opened");
  }
}

TEST_F(VolumeSources, RejectInvalidPatterns) {
  const std::string little = "encoding: raw\nendian: little\n";
  for (const char* pattern :
       {"v.%d.%s 1 2 1", "v.%d%n 1 2 1", "v%99d.raw 1 2 1", "v%99999999999d.raw 1 2 1",
        "v%d.raw 0 2000000000 1", "v%d.raw 2 1 1", "v%d.raw 1 2 0", "v%d.raw", "v%d.raw 1 two 1",
        "%%%d%s 1 2 1", "%d%%s 1 2 1"}) {
    SCOPED_TRACE(pattern);
    for (const char* field : {"data file: ", "DataFile: ", "# hidden\rdata file: "}) {
      const std::string more = little + field + pattern + "\n";
      const std::string error = error_of_opening(nhdr_file("v.nhdr", "short", more));
      EXPECT_NE(error.find("%03d"), std::string::npos) << error;
    }
  }
  EXPECT_NE(
      error_of_opening(nhdr_file("v.nhdr", "short", std::string(5'000'000, 'x'))).find("bytes"),
      std::string::npos);
}

// ---- memory

// The resident memory of this process, in bytes.
std::int64_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  std::int64_t all_pages = 0;
  std::int64_t resident_pages = 0;
  in >> all_pages >> resident_pages;
  return resident_pages * 4096;
}

TEST_F(VolumeSources, ReadLargeVolumesWithMemoryForASlab) {
  const RawLayout layout{.dims = {2048, 1024, 2048}, .type = StoredType::kU8};
  const fs::path file = folder_.file("large.raw", "");
  std::error_code error;
  fs::resize_file(file, std::uintmax_t{1} << 32, error);  // A sparse file.
  if (error) GTEST_SKIP() << "NOT TESTED: no file of 4 GiB here: " << error.message();
  std::fstream(file).seekp((std::int64_t{2048} * 1024 * 2000)).put('\x2A');

  const std::int64_t before = resident_bytes();
  const auto source = open_volume(file, {.raw = layout});
  Samples slab;
  constexpr std::int64_t kSlabBytes = 2048 * 1024 * 4;
  for (const std::int32_t first : {0, 1000, 2000, 2044}) source->read(first, 4, slab);
  source->read(2000, 4, slab);
  EXPECT_EQ(std::get<std::vector<std::uint8_t>>(slab)[0], 0x2A);
  EXPECT_LT(resident_bytes() - before, 3 * kSlabBytes);
}

}  // namespace
}  // namespace multitetra

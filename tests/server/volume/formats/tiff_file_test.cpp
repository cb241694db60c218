// TIFF and PNG images written by libtiff and libpng, and descriptions of ImageJ and OME-TIFF.
#include "server/volume/formats/tiff_file.hpp"

#include <gtest/gtest.h>

#include <png.h>
#include <tiffio.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/tiff_description.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::expect_contains;

constexpr std::uint32_t kWidth = 37;
constexpr std::uint32_t kHeight = 21;

struct PageOptions {
  std::uint16_t compression = COMPRESSION_NONE;
  std::uint16_t components = 1;
  bool is_planar = false;
  std::uint32_t tile = 0;  // Side of a tile in pixels, or 0 for strips.
  const char* mode = "w";  // "w8": BigTIFF, "wb": big-endian.
  std::string description = {};
  double resolution = 0;
  std::uint16_t resolution_unit = RESUNIT_INCH;
};

// The sample of component c in column x, row y of a page.
int number_at(std::uint32_t x, std::uint32_t y, std::uint32_t page, std::uint32_t c) {
  return static_cast<int>((x + 3 * y + 50 * page + 7 * c) % 101);
}

template <typename Number>
void write_tiff(const fs::path& file, std::uint32_t pages, std::uint16_t format,
                const PageOptions& options = {}) {
  TIFF* const tiff = TIFFOpen(file.c_str(), options.mode);
  ASSERT_NE(tiff, nullptr);
  for (std::uint32_t page = 0; page < pages; ++page) {
    const std::uint32_t c = options.components;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * sizeof(Number));
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, options.components);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, c == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
                 options.is_planar ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, options.compression);
    if (options.resolution > 0) {
      TIFFSetField(tiff, TIFFTAG_XRESOLUTION, options.resolution);
      TIFFSetField(tiff, TIFFTAG_YRESOLUTION, 2 * options.resolution);
      TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, options.resolution_unit);
    }
    if (page == 0 && !options.description.empty()) {
      TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, options.description.c_str());
    }
    const std::uint32_t width = options.tile > 0 ? options.tile : kWidth;
    const std::uint32_t height = options.tile > 0 ? options.tile : 4;
    if (options.tile > 0) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, options.tile);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, options.tile);
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, height);
    }
    const std::uint32_t planes = options.is_planar ? c : 1;
    const std::uint32_t together = options.is_planar ? 1 : c;
    std::uint32_t index = 0;
    for (std::uint32_t plane = 0; plane < planes; ++plane) {
      for (std::uint32_t y0 = 0; y0 < kHeight; y0 += height) {
        for (std::uint32_t x0 = 0; x0 < kWidth; x0 += width, ++index) {
          const std::uint32_t rows = options.tile > 0 ? height : std::min(height, kHeight - y0);
          std::vector<Number> block;
          for (std::uint32_t y = y0; y < y0 + rows; ++y) {
            for (std::uint32_t x = x0; x < x0 + width; ++x) {
              for (std::uint32_t i = 0; i < together; ++i) {
                block.push_back(static_cast<Number>(number_at(x, y, page, plane + i)));
              }
            }
          }
          const auto bytes = static_cast<tmsize_t>(block.size() * sizeof(Number));
          if (options.tile > 0) {
            TIFFWriteEncodedTile(tiff, index, block.data(), bytes);
          } else {
            TIFFWriteEncodedStrip(tiff, index, block.data(), bytes);
          }
        }
      }
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

std::vector<double> samples_of(const Volume& volume) {
  return std::visit(
      [](const auto& samples) { return std::vector<double>(samples.begin(), samples.end()); },
      volume.samples);
}

void expect_pages(const fs::path& file, SampleType type, const std::vector<std::uint32_t>& pages,
                  const VolumeChoice& choice = {}, std::uint32_t component = 0) {
  SCOPED_TRACE(file.filename().string());
  const Volume volume = read_volume(file, {.choice = choice});
  EXPECT_EQ(volume.type(), type);
  ASSERT_EQ(volume.dims, (std::array<std::int32_t, 3>{kWidth, kHeight,
                                                      static_cast<std::int32_t>(pages.size())}));
  const std::vector<double> samples = samples_of(volume);
  std::size_t at = 0;
  for (const std::uint32_t page : pages) {
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x, ++at) {
        ASSERT_EQ(samples[at], number_at(x, y, page, component)) << x << " " << y << " " << page;
      }
    }
  }
}

class TiffFile : public ::testing::Test {
 protected:
  template <typename Number>
  fs::path written(std::uint32_t pages, std::uint16_t format, const PageOptions& options = {}) {
    const fs::path file = folder_.path() / ("v" + std::to_string(++files_) + ".tif");
    write_tiff<Number>(file, pages, format, options);
    return file;
  }
  static std::string refusal(const fs::path& file, const VolumeChoice& choice = {}) {
    try {
      (void)read_volume(file, {.choice = choice});
      return "";
    } catch (const VolumeFileError& error) {
      return error.what();
    }
  }

  TemporaryFolder folder_;
  int files_ = 0;
};

TEST_F(TiffFile, ReadsEverySampleType) {
  expect_pages(written<std::uint8_t>(3, SAMPLEFORMAT_UINT), SampleType::kU8, {0, 1, 2});
  expect_pages(written<std::int8_t>(2, SAMPLEFORMAT_INT), SampleType::kI8, {0, 1});
  expect_pages(written<std::uint16_t>(2, SAMPLEFORMAT_UINT), SampleType::kU16, {0, 1});
  expect_pages(written<std::int16_t>(2, SAMPLEFORMAT_INT), SampleType::kI16, {0, 1});
  expect_pages(written<std::uint32_t>(2, SAMPLEFORMAT_UINT), SampleType::kF32, {0, 1});
  expect_pages(written<std::int32_t>(2, SAMPLEFORMAT_INT), SampleType::kF32, {0, 1});
  expect_pages(written<std::uint64_t>(2, SAMPLEFORMAT_UINT), SampleType::kF32, {0, 1});
  expect_pages(written<std::int64_t>(2, SAMPLEFORMAT_INT), SampleType::kF32, {0, 1});
  expect_pages(written<float>(2, SAMPLEFORMAT_IEEEFP), SampleType::kF32, {0, 1});
  expect_pages(written<double>(2, SAMPLEFORMAT_IEEEFP), SampleType::kF32, {0, 1});
}

TEST_F(TiffFile, ConvertsHalfFloatsToF32) {
  const fs::path file = folder_.path() / "half.tif";
  TIFF* const tiff = TIFFOpen(file.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 6);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  // 1, -2, the largest, the smallest positive, infinity, NaN.
  std::array<std::uint16_t, 6> halves = {0x3C00, 0xC000, 0x7BFF, 0x0001, 0x7C00, 0x7E00};
  TIFFWriteScanline(tiff, halves.data(), 0);
  TIFFClose(tiff);
  const std::vector<double> samples = samples_of(read_volume(file));
  EXPECT_EQ(samples[0], 1);
  EXPECT_EQ(samples[1], -2);
  EXPECT_EQ(samples[2], 65504);
  EXPECT_EQ(samples[3], std::ldexp(1.0, -24));
  EXPECT_TRUE(std::isnan(samples[4]));  // Infinite samples become void.
  EXPECT_TRUE(std::isnan(samples[5]));
}

TEST_F(TiffFile, ConvertsOneBitMasksToBytes) {
  const fs::path file = folder_.path() / "mask.tif";
  TIFF* const tiff = TIFFOpen(file.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 10);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  std::array<std::uint8_t, 2> bits = {0b10110000, 0b01000000};
  TIFFWriteScanline(tiff, bits.data(), 0);
  TIFFClose(tiff);
  EXPECT_EQ(samples_of(read_volume(file)), (std::vector<double>{1, 0, 1, 1, 0, 0, 0, 0, 0, 1}));
}

TEST_F(TiffFile, ReadsTheSameSamplesFromEveryLayout) {
  for (const int compression :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    for (const std::uint32_t tile : {0U, 16U}) {
      for (const char* mode : {"w", "wb", "w8"}) {
        SCOPED_TRACE(std::to_string(compression) + " " + std::to_string(tile) + " " + mode);
        expect_pages(written<std::uint16_t>(2, SAMPLEFORMAT_UINT,
                                            {.compression = static_cast<std::uint16_t>(compression),
                                             .tile = tile,
                                             .mode = mode}),
                     SampleType::kU16, {0, 1});
      }
    }
  }
}

TEST_F(TiffFile, ReadsInterleavedAndPlanarComponents) {
  for (const bool is_planar : {false, true}) {
    for (const std::uint32_t tile : {0U, 16U}) {
      const fs::path file = written<std::uint8_t>(
          2, SAMPLEFORMAT_UINT, {.components = 3, .is_planar = is_planar, .tile = tile});
      expect_contains(refusal(file), "--component");
      expect_pages(file, SampleType::kU8, {0, 1}, {.component = ComponentChoice::from("2").value()},
                   2);
    }
  }
}

TEST_F(TiffFile, UsesTheResolutionAsSpacingUnlessOfAScreen) {
  const auto spacing = [&](double resolution, std::uint16_t unit) {
    const Volume volume = read_volume(written<std::uint8_t>(
        2, SAMPLEFORMAT_UINT, {.resolution = resolution, .resolution_unit = unit}));
    const bool is_known = volume.spacing[0] != 1;
    EXPECT_EQ(volume.meaning.length_unit, is_known ? "mm" : "");
    return volume.spacing;
  };
  EXPECT_EQ(spacing(72, RESUNIT_INCH), (Vec3{1, 1, 1}));
  EXPECT_EQ(spacing(96, RESUNIT_INCH), (Vec3{1, 1, 1}));
  EXPECT_EQ(spacing(254, RESUNIT_INCH), (Vec3{25.4 / 254, 25.4 / 508, 1}));
  EXPECT_EQ(spacing(100, RESUNIT_CENTIMETER), (Vec3{0.1, 0.05, 1}));
  EXPECT_EQ(spacing(100, RESUNIT_NONE), (Vec3{1, 1, 1}));
}

TEST_F(TiffFile, ReadsImageJHyperstacks) {
  const std::string description =
      "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\nmode=grayscale\n"
      "unit=micron\nspacing=2.5\nfinterval=0.5\nloop=false\n";
  const fs::path file = written<std::uint8_t>(
      12, SAMPLEFORMAT_UINT,
      {.description = description, .resolution = 4, .resolution_unit = RESUNIT_NONE});
  expect_contains(refusal(file), "2 channels. Choose one with --channel");
  expect_contains(refusal(file, {.channel = 0}), "Choose one with --time");
  expect_contains(refusal(file, {.time = 0, .channel = 2}), "it has no channel 2");
  expect_pages(file, SampleType::kU8, {1, 3, 5}, {.time = 0, .channel = 1});
  expect_pages(file, SampleType::kU8, {6, 8, 10}, {.time = 1, .channel = 0});
  const Volume volume = read_volume(file, {.choice = {.time = 1, .channel = 0}});
  EXPECT_EQ(volume.spacing, (Vec3{0.25, 0.125, 2.5}));
  EXPECT_EQ(volume.meaning.length_unit, "µm");
  const VolumeContents contents = open_volume(file, {.choice = {.first = true}})->contents();
  EXPECT_EQ(contents.times, (SourceTimes{.count = 2, .at = {0, 0.5}, .unit = "s"}));
  ASSERT_EQ(contents.fields.size(), 2U);
  EXPECT_EQ(contents.fields[1].channel, 1);
}

TEST_F(TiffFile, ReadsLargeImageJStacksOfOnePage) {
  const fs::path file = written<std::uint16_t>(
      1, SAMPLEFORMAT_UINT, {.mode = "wb", .description = "ImageJ=1.53t\nimages=3\nslices=3\n"});
  TIFF* const tiff = TIFFOpen(file.c_str(), "r");
  std::uint64_t* offsets = nullptr;
  TIFFGetField(tiff, TIFFTAG_STRIPOFFSETS, &offsets);
  const std::uint64_t begin = offsets[0];
  TIFFClose(tiff);
  // The bytes after the first page, here the directory and zeros, are read as the other two pages.
  const std::size_t page = std::size_t{2} * kWidth * kHeight;
  const std::string bytes = bytes_of_file(file) + std::string(2 * page, '\0');
  const Volume volume = read_volume(folder_.file("large.tif", bytes));
  EXPECT_EQ(volume.dims[2], 3);
  const auto& samples = std::get<std::vector<std::uint16_t>>(volume.samples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[begin + at]); };
    ASSERT_EQ(samples[i], 256 * byte(2 * i) + byte(2 * i + 1)) << i;
  }
  EXPECT_EQ(samples[kWidth + 3], number_at(3, 1, 0, 0));
  expect_contains(refusal(folder_.file("cut.tif", bytes_of_file(file))), "ends too early");
}

TEST_F(TiffFile, AppliesPageOrderAndUnitsOfOme) {
  const std::string description =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?><OME "
      "xmlns=\"http://www.openmicroscopy.org/\"><Image "
      "ID=\"Image:0\"><Pixels DimensionOrder=\"XYZCT\" Type=\"uint8\" SizeX=\"37\" SizeY=\"21\" "
      "SizeZ=\"3\" SizeC=\"2\" SizeT=\"2\" PhysicalSizeX=\"0.2\" PhysicalSizeY=\"0.3\" "
      "PhysicalSizeZ=\"1.5\" PhysicalSizeXUnit=\"nm\" PhysicalSizeYUnit=\"nm\" "
      "PhysicalSizeZUnit=\"nm\" TimeIncrement=\"2\"><Channel Name=\"DAPI\" "
      "Color=\"65535\"/><Channel "
      "Name=\"GFP\" Color=\"-16776961\"/><TiffData/></Pixels></Image></OME>";
  const fs::path file = written<std::uint8_t>(12, SAMPLEFORMAT_UINT, {.description = description});
  expect_pages(file, SampleType::kU8, {3, 4, 5}, {.time = 0, .channel = 1});
  expect_pages(file, SampleType::kU8, {6, 7, 8}, {.time = 1, .channel = 0});
  const Volume volume = read_volume(file, {.choice = {.time = 1, .channel = 0}});
  EXPECT_EQ(volume.spacing, (Vec3{0.2, 0.3, 1.5}));
  EXPECT_EQ(volume.meaning.length_unit, "nm");
  const VolumeContents contents = open_volume(file, {.choice = {.first = true}})->contents();
  EXPECT_EQ(contents.fields[0].name, "DAPI");
  EXPECT_EQ(contents.fields[1].name, "GFP");
  EXPECT_EQ(contents.fields[0].color, 0x0000ffU);
  EXPECT_EQ(contents.fields[1].color, 0xff0000U);
  EXPECT_EQ(contents.times.at, (std::vector<double>{0, 2}));
}

TEST(TiffDescription, AcceptsOmeBlocksStartingAnywhere) {
  const auto parsed = [](const std::string& pixels, const std::string& blocks) {
    return parse_ome_description(
        "<OME><Image><Pixels " + pixels + ">" + blocks + "</Pixels></Image></OME>", 1);
  };
  const std::string sizes = "DimensionOrder=\"XYCZT\" SizeZ=\"3\" SizeC=\"2\" SizeT=\"1\"";
  const auto plain = parsed(sizes, "");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->pages, (std::vector<std::size_t>{0, 2, 4, 1, 3, 5}));
  const auto swapped =
      parsed(sizes,
             "<TiffData IFD=\"3\" PlaneCount=\"3\"/><TiffData IFD=\"0\" FirstC=\"1\" "
             "FirstZ=\"1\" PlaneCount=\"3\"/>");
  ASSERT_TRUE(swapped);
  EXPECT_EQ(swapped->pages, (std::vector<std::size_t>{3, 5, 1, 4, 0, 2}));
  EXPECT_FALSE(parsed(sizes, "<TiffData IFD=\"0\" FirstZ=\"3\"/>"));
  EXPECT_FALSE(parsed("SizeZ=\"-3\"", ""));
  for (const std::string order : {"XYuZT", "XYZZT", "XYZC", "ZCTXY", "XYZCTT", "xyzct"}) {
    EXPECT_FALSE(parsed("DimensionOrder=\"" + order + "\" SizeZ=\"3\" SizeC=\"4\" SizeT=\"18\"",
                        "<TiffData IFD=\"3\" FirstZ=\"1\" PlaneCount=\"3\"/>"))
        << order;
  }
  EXPECT_TRUE(parsed("SizeZ=\"3\"", ""));
  EXPECT_FALSE(parsed("SizeZ=\"9999999\" SizeC=\"9999999\" SizeT=\"9999999\"", ""));
  EXPECT_FALSE(parsed(sizes,
                      "<TiffData><UUID FileName=\"a\"/></TiffData><TiffData><UUID "
                      "FileName=\"b\"/></TiffData>"));
  EXPECT_FALSE(parse_ome_description("<OME>", 1));
}

TEST_F(TiffFile, SkipsReducedCopiesAndRejectsDifferingPages) {
  const fs::path file = written<std::uint8_t>(2, SAMPLEFORMAT_UINT);
  const auto append = [&](std::uint32_t width, std::uint32_t kind) {
    TIFF* const tiff = TIFFOpen(file.c_str(), "a");
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, kind);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    std::array<std::uint8_t, 5> row = {1, 2, 3, 4, 5};
    TIFFWriteScanline(tiff, row.data(), 0);
    TIFFClose(tiff);
  };
  append(5, FILETYPE_REDUCEDIMAGE);
  expect_pages(file, SampleType::kU8, {0, 1});
  append(5, 0);
  expect_contains(refusal(file), "its page 3 has another size");
}

TEST_F(TiffFile, ReadsPngSlicesUnchanged) {
  const auto write_png = [&](const std::string& name, bool is_wide, int slice) {
    std::vector<std::uint16_t> wide;
    std::vector<std::uint8_t> narrow;
    for (int i = 0; i < 12; ++i) {
      wide.push_back(static_cast<std::uint16_t>(1000 * slice + i));
      narrow.push_back(static_cast<std::uint8_t>(100 * slice + i));
    }
    const fs::path file = folder_.file(name, "");
    std::FILE* const out = std::fopen(file.c_str(), "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, out);
    png_set_IHDR(png, info, 4, 3, is_wide ? 16 : 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_set_swap(png);
    for (std::size_t y = 0; y < 3; ++y) {
      png_write_row(
          png, is_wide ? reinterpret_cast<png_bytep>(wide.data() + 4 * y) : narrow.data() + 4 * y);
    }
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    std::fclose(out);
  };
  for (const bool is_wide : {false, true}) {
    const std::string name = is_wide ? "wide" : "narrow";
    for (const int slice : {0, 1}) {
      write_png(name + "/s" + std::to_string(9 + slice) + ".png", is_wide, slice);
    }
    const Volume volume = read_volume(folder_.path() / name);
    EXPECT_EQ(volume.dims, (std::array<std::int32_t, 3>{4, 3, 2}));
    EXPECT_EQ(volume.type(), is_wide ? SampleType::kU16 : SampleType::kU8);
    const std::vector<double> samples = samples_of(volume);
    for (std::size_t i = 0; i < 24; ++i) {
      EXPECT_EQ(samples[i], static_cast<double>(i % 12 + (is_wide ? 1000 : 100) * (i / 12)));
    }
    EXPECT_EQ(read_volume(folder_.path() / name / "s9.png").dims[2], 1);
  }
  const std::string whole = bytes_of_file(folder_.path() / "wide/s9.png");
  expect_contains(refusal(folder_.file("cut/a.png", whole.substr(0, whole.size() - 20))), "a.png");
  expect_contains(refusal(folder_.file("cut/b.png", whole.substr(0, 20))), "b.png");
}

}  // namespace
}  // namespace multitetra

// JPEG images written by libjpeg.
#include "server/volume/formats/jpeg_file.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdio>  // jpeglib.h needs it but does not include it.
#include <cstdlib>
#include <string>
#include <vector>

#include <jpeglib.h>

#include "server/volume/volume_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// A JPEG of 16 x 8 pixels with these components.
std::string jpeg(const std::vector<std::uint8_t>& pixel, bool is_progressive = false) {
  jpeg_compress_struct cinfo{};
  jpeg_error_mgr errors{};
  cinfo.err = jpeg_std_error(&errors);
  jpeg_create_compress(&cinfo);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&cinfo, &bytes, &size);
  cinfo.image_width = 16;
  cinfo.image_height = 8;
  cinfo.input_components = static_cast<int>(pixel.size());
  cinfo.in_color_space = pixel.size() == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&cinfo);
  jpeg_set_quality(&cinfo, 100, TRUE);
  if (is_progressive) jpeg_simple_progression(&cinfo);
  jpeg_start_compress(&cinfo, TRUE);
  std::vector<std::uint8_t> row;
  for (int x = 0; x < 16; ++x) row.insert(row.end(), pixel.begin(), pixel.end());
  for (int y = 0; y < 8; ++y) {
    JSAMPROW line = row.data();
    jpeg_write_scanlines(&cinfo, &line, 1);
  }
  jpeg_finish_compress(&cinfo);
  std::string file(reinterpret_cast<const char*>(bytes), size);
  jpeg_destroy_compress(&cinfo);
  std::free(bytes);
  return file;
}

std::vector<std::uint8_t> samples_of(const StoredVolume& image) {
  std::vector<std::uint8_t> samples(image.header.slice_bytes());
  image.slices->read(0, 1, reinterpret_cast<std::byte*>(samples.data()));
  return samples;
}

class JpegFile : public ::testing::Test {
 protected:
  std::string refusal(const std::string& bytes) {
    try {
      (void)samples_of(open_jpeg(folder_.file("damaged.jpg", bytes)));
    } catch (const VolumeFileError& error) {
      return error.what();
    }
    return "accepted";
  }

  TemporaryFolder folder_;
};

TEST_F(JpegFile, ReadsGreyAndColors) {
  for (const bool is_progressive : {false, true}) {
    const StoredVolume grey = open_jpeg(folder_.file("grey.jpg", jpeg({117}, is_progressive)));
    EXPECT_EQ(grey.header.dims, (std::array<std::int64_t, 3>{16, 8, 1}));
    EXPECT_EQ(grey.header.components, 1);
    EXPECT_EQ(samples_of(grey), std::vector<std::uint8_t>(128, 117));
    const StoredVolume red =
        open_jpeg(folder_.file("red.jpg", jpeg({200, 10, 30}, is_progressive)));
    EXPECT_EQ(red.header.components, 3);
    const std::vector<std::uint8_t> samples = samples_of(red);
    EXPECT_NEAR(samples[0], 200, 2);
    EXPECT_NEAR(samples[1], 10, 2);
    EXPECT_NEAR(samples[2], 30, 2);
  }
}

TEST_F(JpegFile, ReadsImagesOfAFolderAsSlices) {
  for (const int slice : {9, 10, 11}) {
    folder_.file("stack/s" + std::to_string(slice) + ".jpg",
                 jpeg({static_cast<std::uint8_t>(10 * slice)}));
  }
  const Volume volume = read_volume(folder_.path() / "stack");
  EXPECT_EQ(volume.dims, (std::array<std::int32_t, 3>{16, 8, 3}));
  const auto& samples = std::get<std::vector<std::uint8_t>>(volume.samples);
  EXPECT_EQ(samples[0], 90);
  EXPECT_EQ(samples[128], 100);
  EXPECT_EQ(samples[256], 110);
  // A single image, recognized by its content.
  EXPECT_EQ(read_volume(folder_.file("one.bin", jpeg({5}))).dims[2], 1);
  // Previews next to PNG images are ignored.
  folder_.file("stack/s9.png", "");
  EXPECT_THROW((void)read_volume(folder_.path() / "stack"), VolumeFileError);
}

TEST_F(JpegFile, RejectsTruncatedImages) {
  // libjpeg replaces missing data by grey.
  const std::string whole = jpeg({117});
  EXPECT_EQ(refusal(whole), "accepted");
  for (const std::size_t kept :
       {whole.size() - 2, whole.size() - 10, std::size_t{100}, std::size_t{2}}) {
    EXPECT_NE(refusal(whole.substr(0, kept)).find("damaged.jpg"), std::string::npos) << kept;
  }
  EXPECT_NE(refusal("").find("it is not a complete JPEG image"), std::string::npos);
}

}  // namespace
}  // namespace multitetra

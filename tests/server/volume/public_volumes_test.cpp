// Compares the public volumes on this machine with their list.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <ostream>
#include <string>

#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

struct PublicVolume {
  std::string file;
  std::array<std::int32_t, 3> dims;
  SampleType type;
  Vec3 spacing;
  double min;
  double max;
  std::optional<RawLayout> raw = std::nullopt;
};

void PrintTo(const PublicVolume& volume, std::ostream* out) { *out << volume.file; }

class PublicVolumes : public ::testing::TestWithParam<PublicVolume> {};

TEST_P(PublicVolumes, MatchTheListedStatistics) {
  const PublicVolume& expected = GetParam();
  const std::filesystem::path file = std::filesystem::path(MULTITETRA_PUBLIC_DATA) / expected.file;
  if (!std::filesystem::exists(file)) {
    GTEST_SKIP() << "NOT TESTED: the public volume " << expected.file << " is not on this machine";
  }
  const Volume volume = read_volume(file, {.raw = expected.raw});
  EXPECT_EQ(volume.dims, expected.dims);
  EXPECT_EQ(volume.type(), expected.type);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(volume.spacing[axis], expected.spacing[axis], 1e-6);
  }
  const auto [min, max] = std::visit(
      [](const auto& samples) {
        const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
        return std::pair(static_cast<double>(*low), static_cast<double>(*high));
      },
      volume.samples);
  EXPECT_NEAR(min, expected.min, 1e-3);
  EXPECT_NEAR(max, expected.max, 1e-3);
}

constexpr SampleType kU8 = SampleType::kU8;
constexpr SampleType kU16 = SampleType::kU16;
constexpr SampleType kI16 = SampleType::kI16;
constexpr SampleType kF32 = SampleType::kF32;

INSTANTIATE_TEST_SUITE_P(
    All, PublicVolumes,
    ::testing::Values(
        PublicVolume{"cthead/CThead.nhdr", {256, 256, 113}, kU16, {1, 1, 2}, 0, 3272},
        PublicVolume{"headsq/quarter.nhdr", {64, 64, 93}, kI16, {3.2, 3.2, 1.5}, 0, 3926},
        PublicVolume{"tooth16/tooth.nhdr", {103, 94, 161}, kU16, {1, 1, 1}, 0, 1300},
        PublicVolume{"stent.nrrd", {128, 128, 256}, kF32, {1, 1, 1}, 0, 1},
        PublicVolume{"MRI-Head_256x256x256.nrrd", {256, 256, 256}, kU8, {1, 1, 1}, 0, 255},
        PublicVolume{"engine/engine.mhd", {256, 256, 128}, kU8, {1, 1, 1}, 0, 255},
        PublicVolume{
            "bonsai_small/bonsai_small.mhd", {256, 256, 91}, kU8, {1.172, 1.172, 2}, 0, 255},
        PublicVolume{"HeadMRVolume/HeadMRVolume.mhd", {48, 62, 42}, kU8, {4, 4, 4}, 0, 255},
        PublicVolume{"Brain_float/Brain.mhd", {100, 100, 38}, kF32, {1, 1, 1}, 0, 209.638},
        PublicVolume{"Iguana.nii.gz", {210, 256, 179}, kU8, {0.1018, 0.1018, 0.1018}, 0, 229},
        PublicVolume{"avg152T1_RL_nifti.nii.gz", {91, 109, 91}, kU8, {2, 2, 2}, 0, 255},
        PublicVolume{"hydrogen.vtk", {64, 64, 64}, kF32, {1, 1, 1}, 0, 1},
        PublicVolume{"ironProt.vtk", {68, 68, 68}, kU8, {1, 1, 1}, 0, 255},
        PublicVolume{"fuel_64x64x64_uint8.raw",
                     {64, 64, 64},
                     kU8,
                     {1, 1, 1},
                     0,
                     255,
                     RawLayout{.dims = {64, 64, 64}}},
        PublicVolume{
            "head_128x128x112.dat",
            {128, 128, 112},
            kU16,
            {1, 1, 1},
            0,
            3272,
            RawLayout{.dims = {128, 128, 112}, .type = StoredType::kU16, .header_bytes = 6}}),
    [](const ::testing::TestParamInfo<PublicVolume>& volume) {
      std::string label = volume.param.file;
      std::replace_if(
          label.begin(), label.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
      return label;
    });

}  // namespace
}  // namespace multitetra

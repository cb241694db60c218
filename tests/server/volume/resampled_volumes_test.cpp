// Sheared grids, as of a CT with a tilted gantry, are resampled to rectangular ones: images
// linearly, label maps with the nearest sample.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <variant>

#include "common/base/affine.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Rows and slices are shifted: no two axes are at right angles.
constexpr std::array<std::int32_t, 3> kShearedDims = {40, 36, 20};
const Affine kSheared = {.columns = {Vec3{1, 0, 0}, Vec3{0.2, 1.1, 0}, Vec3{-0.15, 0.6, 2}},
                         .translation = {5, -7, 11}};
const Vec3 kMiddle = kSheared({19.5, 17.5, 9.5});

int label_at(const Vec3& place) {
  const double radius = length(difference(place, kMiddle));
  return radius < 7 ? 3 : radius < 11 ? 7 : 0;
}

double linear_at(const Vec3& place) { return 2 * place[0] - 3 * place[1] + place[2]; }

class ResampledVolumes : public ::testing::Test {
 protected:
  template <typename T>
  fs::path written(const std::string& name, const std::string& type,
                   const std::function<double(const Vec3&)>& value_at) {
    std::string bytes = "NRRD0004\ntype: " + type +
                        "\ndimension: 3\nsizes: 40 36 20\nspace: LPS\nendian: little\n"
                        "encoding: raw\nspace directions: (1,0,0) (0.2,1.1,0) (-0.15,0.6,2)\n"
                        "space origin: (5,-7,11)\n\n";
    for (double z = 0; z < kShearedDims[2]; ++z) {
      for (double y = 0; y < kShearedDims[1]; ++y) {
        for (double x = 0; x < kShearedDims[0]; ++x) {
          const auto value = static_cast<T>(value_at(kSheared({x, y, z})));
          bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
        }
      }
    }
    return folder_.file(name, bytes);
  }
  fs::path labels() { return written<std::uint8_t>("labels.nrrd", "uint8", label_at); }
  fs::path image() { return written<float>("image.nrrd", "float", linear_at); }

  TemporaryFolder folder_;
};

Volume resampled(const fs::path& file, bool nearest = false) {
  return read_volume(file, {.choice = {.resample = true, .nearest = nearest}});
}

// Calls use(place, value) for each sample.
void for_each_sample(const Volume& volume, const std::function<void(const Vec3&, double)>& use) {
  std::visit(
      [&](const auto& samples) {
        std::size_t at = 0;
        for (std::int32_t z = 0; z < volume.dims[2]; ++z) {
          for (std::int32_t y = 0; y < volume.dims[1]; ++y) {
            for (std::int32_t x = 0; x < volume.dims[0]; ++x, ++at) {
              use(volume.index_to_world(
                      {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}),
                  static_cast<double>(samples[at]));
            }
          }
        }
      },
      volume.samples);
}

TEST_F(ResampledVolumes, LabelsHaveTheGridOfTheImage) {
  const Volume image = resampled(this->image());
  const Volume map = resampled(labels(), /*nearest=*/true);
  EXPECT_EQ(map.dims, image.dims);
  EXPECT_EQ(map.index_to_world, image.index_to_world);
  EXPECT_EQ(map.spacing, image.spacing);
  const std::array<Vec3, 3>& steps = map.index_to_world.columns;
  EXPECT_NEAR(dot(steps[0], steps[1]), 0, 1e-9);
  EXPECT_NEAR(dot(steps[0], steps[2]), 0, 1e-9);
  EXPECT_NEAR(dot(steps[1], steps[2]), 0, 1e-9);
}

TEST_F(ResampledVolumes, LabelsKeepTheirValuesTypesVolumesAndPlaces) {
  const Volume map = resampled(labels(), /*nearest=*/true);
  EXPECT_TRUE(std::holds_alternative<std::vector<std::uint8_t>>(map.samples));
  std::map<double, double> volumes;
  Vec3 moment{};
  const double of_sample = std::abs(map.index_to_world.determinant());
  for_each_sample(map, [&](const Vec3& place, double value) {
    volumes[value] += of_sample;
    if (value == 3) moment = moved(moment, of_sample, place);
  });
  ASSERT_EQ(volumes.size(), 3u);
  const auto ball = [](double radius) { return 4.0 / 3 * std::acos(-1) * std::pow(radius, 3); };
  EXPECT_NEAR(volumes[3], ball(7), 0.03 * ball(7));
  EXPECT_NEAR(volumes[7], ball(11) - ball(7), 0.03 * ball(11));
  EXPECT_LT(length(difference(scaled(moment, 1 / volumes[3]), kMiddle)), 0.1);
}

TEST_F(ResampledVolumes, ImagesAreInterpolatedAndVoidBeyondTheirSlices) {
  std::size_t samples = 0;
  std::size_t voids = 0;
  for_each_sample(resampled(image()), [&](const Vec3& place, double value) {
    ++samples;
    voids += std::isnan(value) ? 1u : 0u;
    if (!std::isnan(value)) {
      EXPECT_NEAR(value, linear_at(place), 1e-4);
    }
  });
  const std::size_t stored = std::size_t{40} * 36 * 20;
  EXPECT_GT(samples - voids, stored * 94 / 100);
  EXPECT_LE(samples - voids, stored);
}

TEST_F(ResampledVolumes, OthersAreUnchanged) {
  const std::string bytes =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\nabcdefgh";
  const Volume volume = resampled(folder_.file("straight.nrrd", bytes));
  EXPECT_EQ(volume.dims, (std::array<std::int32_t, 3>{2, 2, 2}));
  EXPECT_TRUE(std::holds_alternative<std::vector<std::uint8_t>>(volume.samples));
}

TEST_F(ResampledVolumes, RequireTheOption) {
  try {
    (void)read_volume(labels());
    FAIL() << "a sheared grid is read";
  } catch (const VolumeFileError& problem) {
    EXPECT_NE(
        std::string(problem.what())
            .find("are not at right angles to each other (a sheared grid or a tilted gantry). "
                  "Resample it onto a rectangular grid with --resample."),
        std::string::npos)
        << problem.what();
  }
}

// Converters of tilted CTs write both forms; only the sform has the tilt.
TEST_F(ResampledVolumes, NiftiIsResampledByItsShearedSform) {
  std::string bytes = nifti({2, 8}, std::string(24, '\1'), Endian::kLittle);
  const auto put = [&](std::size_t at, float value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  };
  const std::int16_t code = 1;
  std::memcpy(bytes.data() + 254, &code, sizeof code);
  const std::array<float, 12> rows = {1, 0, 0, 10, 0, 2, 1, 20, 0, 0, 3, 30};
  for (std::size_t i = 0; i < rows.size(); ++i) put(280 + 4 * i, rows[i]);
  const fs::path file = folder_.file("tilted.nii", bytes);
  EXPECT_EQ(read_volume(file).dims, (std::array<std::int32_t, 3>{4, 3, 2}));
  const Volume volume = resampled(file, /*nearest=*/true);
  EXPECT_EQ(volume.dims, (std::array<std::int32_t, 3>{4, 4, 2}));
  EXPECT_EQ(volume.spacing, (Vec3{1, 2, 3}));
}

}  // namespace
}  // namespace multitetra

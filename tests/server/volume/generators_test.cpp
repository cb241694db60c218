#include "server/volume/generators/generators.hpp"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <variant>
#include <vector>

#include "common/base/exact_sine.hpp"
#include "server/volume/generators/sample_noise.hpp"
#include "server/volume/generators/written_nrrd.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

double sample(const Volume& volume, std::int32_t x, std::int32_t y, std::int32_t z) {
  return std::visit(
      [&](const auto& samples) { return static_cast<double>(samples[volume.index(x, y, z)]); },
      volume.samples);
}

// A volume with the positions of its samples in [-1, 1].
struct Field {
  Volume volume;
  [[nodiscard]] double place(std::int32_t i) const {
    return -1 + 2.0 * i / static_cast<double>(volume.dims[0] - 1);
  }
};

template <typename Formula>
void expect_formula(GeneratorKind kind, const Formula& formula) {
  const Field field{generate(kind, {.size = 9})};
  for (std::int32_t z = 0; z < 9; ++z) {
    for (std::int32_t y = 0; y < 9; ++y) {
      for (std::int32_t x = 0; x < 9; ++x) {
        EXPECT_NEAR(sample(field.volume, x, y, z),
                    formula(field.place(x), field.place(y), field.place(z)), 1e-6);
      }
    }
  }
}

TEST(Generators, EvaluateTheirFormulas) {
  using std::cos;
  using std::sin;
  constexpr double kPi = std::numbers::pi;
  expect_formula(GeneratorKind::kSphere,
                 [](double x, double y, double z) { return 0.75 - std::hypot(x, y, z); });
  expect_formula(GeneratorKind::kTorus, [](double x, double y, double z) {
    return 0.25 - std::hypot(std::hypot(x, y) - 0.6, z);
  });
  expect_formula(GeneratorKind::kGyroid, [](double x, double y, double z) {
    const double a = 2 * kPi * x;
    const double b = 2 * kPi * y;
    const double c = 2 * kPi * z;
    return sin(a) * cos(b) + sin(b) * cos(c) + sin(c) * cos(a);
  });
  expect_formula(GeneratorKind::kMarschnerLobb, [](double x, double y, double z) {
    const double ripple = cos(2 * kPi * 6 * cos(kPi * std::hypot(x, y) / 2));
    return (1 - sin(kPi * z / 2) + 0.25 * (1 + ripple)) / (2 * 1.25);
  });
}

TEST(Generators, VoxelizeTheBox) {
  const Volume volume = generate(GeneratorKind::kBox, {.size = 17});
  EXPECT_EQ(volume.type(), SampleType::kU8);
  const auto& samples = std::get<std::vector<std::uint8_t>>(volume.samples);
  EXPECT_EQ(std::count(samples.begin(), samples.end(), 255), 9 * 7 * 5);
  EXPECT_EQ(std::count(samples.begin(), samples.end(), 0), 17 * 17 * 17 - 9 * 7 * 5);
  EXPECT_EQ(sample(volume, 4, 5, 6), 255);
  EXPECT_EQ(sample(volume, 3, 5, 6), 0);
}

TEST(Generators, PlaceTheTissuesOfTheHeadByTheTable) {
  const Volume volume = generate(GeneratorKind::kHead, {.size = 101});  // Steps of 0.02.
  EXPECT_EQ(volume.type(), SampleType::kI16);
  const auto at = [&](double x, double y, double z) {
    const auto index = [](double place) {
      return static_cast<std::int32_t>(std::lround((place + 1) * 50));
    };
    return sample(volume, index(x), index(y), index(z));
  };
  EXPECT_EQ(at(-1, -1, -1), -1000);   // air
  EXPECT_EQ(at(0, 0.9, 0), 1000);     // skull, between 0.874 and 0.92
  EXPECT_EQ(at(0, -0.5, 0), 200);     // brain
  EXPECT_EQ(at(-0.22, 0, -0.24), 0);  // ventricles
  EXPECT_EQ(at(0.22, 0, -0.24), 0);
  EXPECT_EQ(at(0, 0.4, -0.26), 300);  // tumour
  EXPECT_EQ(at(0, 0.1, 0.62), 0);     // cyst
  EXPECT_EQ(at(0.06, -0.1, 0.62), 300);
  // The long axis of the tilted ventricle points to (cos 108, sin 108), not to the mirrored side.
  EXPECT_EQ(at(-0.32, 0.3, -0.24), 0);
  EXPECT_EQ(at(-0.12, 0.3, -0.24) == 0, false);
}

TEST(Generators, PlaceTheHeadsSurfaceOnTheEllipsoid) {
  const Volume volume = generate(GeneratorKind::kHead, {.size = 101});
  // Along x through the center: air to skull crosses 0, half way, at x = -0.69.
  std::int32_t i = 0;
  while (sample(volume, i + 1, 50, 50) <= 0) ++i;
  const double a = sample(volume, i, 50, 50);
  const double b = sample(volume, i + 1, 50, 50);
  EXPECT_NEAR(-1 + 0.02 * (i - a / (b - a)), -0.69, 0.002);
}

// A hash of all bits of all samples. The tests pin it to detect differences between machines.
std::uint64_t fingerprint(const Volume& volume) {
  std::uint64_t sum = 0;
  std::visit(
      [&](const auto& samples) {
        for (const auto value : samples) {
          std::uint64_t bits = 0;
          std::memcpy(&bits, &value, sizeof(value));
          sum = scattered(sum + bits);
        }
      },
      volume.samples);
  return sum;
}

TEST(Generators, MatchTheGoldenDigests) {
  const auto of = [](GeneratorKind kind) {
    return fingerprint(generate(kind, {.size = 17, .noise = 0.1, .seed = 5}));
  };
  EXPECT_EQ(of(GeneratorKind::kSphere), 7450107749470063718u);
  EXPECT_EQ(of(GeneratorKind::kTorus), 1489613364749177765u);
  EXPECT_EQ(of(GeneratorKind::kGyroid), 1768014055877975435u);
  EXPECT_EQ(of(GeneratorKind::kMarschnerLobb), 12741951239037212122u);
  EXPECT_EQ(of(GeneratorKind::kBox), 5636230399604448757u);
  EXPECT_EQ(of(GeneratorKind::kHead), 3051420485272265083u);
}

TEST(Generators, AreIndependentOfThreadCount) {
  for (const GeneratorKind kind : kGeneratorKinds) {
    const GeneratorOptions options = {.size = 20, .noise = 3, .seed = 7};
    const Volume many = generate(kind, options);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(generate(kind, options).samples, many.samples) << name(kind);
  }
}

TEST(Generators, AddNoiseOfTheGivenDeviationAndSeed) {
  const auto of = [](double noise, std::uint64_t seed) {
    return std::get<std::vector<float>>(
        generate(GeneratorKind::kSphere, {.size = 33, .noise = noise, .seed = seed}).samples);
  };
  const std::vector<float> clean = of(0, 1);
  const std::vector<float> noisy = of(2.5, 1);
  EXPECT_EQ(of(2.5, 1), noisy);
  EXPECT_NE(of(2.5, 2), noisy);
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const double difference = double{noisy[i]} - double{clean[i]};
    sum += difference;
    squares += difference * difference;
  }
  const auto count = static_cast<double>(clean.size());
  EXPECT_NEAR(sum / count, 0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / count), 2.5, 0.05);
}

TEST(Generators, ClampNoiseToTheIntegerRange) {
  const Volume volume = generate(GeneratorKind::kBox, {.size = 17, .noise = 400});
  const auto& samples = std::get<std::vector<std::uint8_t>>(volume.samples);
  EXPECT_EQ(*std::min_element(samples.begin(), samples.end()), 0);
  EXPECT_EQ(*std::max_element(samples.begin(), samples.end()), 255);
}

TEST(Generators, ComputeSinesExactlyAtQuarterTurns) {
  for (int i = -3000; i <= 3000; ++i) {
    const double turns = i / 997.0;
    EXPECT_NEAR(sine_of_turns(turns), std::sin(2 * std::numbers::pi * turns), 2e-14) << turns;
  }
  EXPECT_EQ(sine_of_turns(0), 0);
  EXPECT_DOUBLE_EQ(sine_of_turns(0.25), 1);
  EXPECT_DOUBLE_EQ(cosine_of_turns(0.5), -1);
}

TEST(Generators, AreWrittenSlabBySlab) {
  const TemporaryFolder folder;
  const GeneratorOptions options = {.size = 257, .noise = 20, .seed = 3};  // Three slabs.
  const auto file = folder.path() / "head.nrrd";
  std::vector<std::int32_t> written;
  write_nrrd(file, *generated_volume(GeneratorKind::kHead, options),
             [&](std::int32_t slices) { written.push_back(slices); });
  EXPECT_EQ(written.size(), 3U);
  EXPECT_EQ(written.back(), 257);
  EXPECT_TRUE(read_volume(file).samples == generate(GeneratorKind::kHead, options).samples);
}

TEST(Generators, RoundTripNames) {
  for (const GeneratorKind kind : kGeneratorKinds) {
    EXPECT_EQ(generator_kind_from(name(kind)), kind);
  }
  EXPECT_EQ(generator_kind_from("cube"), std::nullopt);
}

TEST(Generators, SuggestIsovaluesInsideTheRange) {
  for (const GeneratorKind kind : kGeneratorKinds) {
    const Volume volume = generate(kind, {.size = 32});
    const auto [low, high] = std::visit(
        [](const auto& samples) {
          const auto [min, max] = std::minmax_element(samples.begin(), samples.end());
          return std::pair(static_cast<double>(*min), static_cast<double>(*max));
        },
        volume.samples);
    EXPECT_LT(low, suggested_isovalue(kind)) << name(kind);
    EXPECT_GT(high, suggested_isovalue(kind)) << name(kind);
  }
}

TEST(Generators, RejectOptionsOutsideTheirRange) {
  const auto kind = GeneratorKind::kSphere;
  EXPECT_THROW((void)generate(kind, {.size = 1}), std::invalid_argument);
  EXPECT_THROW((void)generate(kind, {.size = 4098}), std::invalid_argument);
  EXPECT_THROW((void)generate(kind, {.size = 4, .noise = -1}), std::invalid_argument);
  EXPECT_THROW((void)generate(kind, {.size = 4, .noise = std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace multitetra

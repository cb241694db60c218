#include "server/volume/generators/generators.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "common/base/exact_sine.hpp"
#include "common/base/in_parallel.hpp"
#include "server/volume/generators/head_phantom.hpp"
#include "server/volume/generators/sample_noise.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kMaxSize = (std::int32_t{1} << 12) + 1;

struct Kind {
  std::string_view name;
  double isovalue;
};

constexpr std::array<Kind, kGeneratorKinds.size()> kKinds = {{{"sphere", 0},
                                                              {"torus", 0},
                                                              {"gyroid", 0},
                                                              {"marschner-lobb", 0.5},
                                                              {"box", 127.5},
                                                              {"head", 500.5}}};

const Kind& facts(GeneratorKind kind) { return kKinds[static_cast<std::size_t>(kind)]; }

// Computes the values of one row along x.
using FillRow = std::function<void(std::int32_t y, std::int32_t z, std::span<double> row)>;

template <typename Sample>
Sample sample_of(double value) {
  if constexpr (std::is_floating_point_v<Sample>) {
    return static_cast<Sample>(value);
  } else {
    using Limits = std::numeric_limits<Sample>;
    return static_cast<Sample>(
        std::clamp<double>(std::floor(value + 0.5), Limits::min(), Limits::max()));
  }
}

// Returns the coordinates of samples along a side: from -1 to 1, symmetric to the bit.
std::vector<double> coordinates(std::int32_t size) {
  std::vector<double> at(static_cast<std::size_t>(size));
  for (std::int32_t i = 0; i < size; ++i) {
    at[static_cast<std::size_t>(i)] = static_cast<double>(2 * i - (size - 1)) / (size - 1);
  }
  return at;
}

template <typename Function>
std::vector<double> mapped(const std::vector<double>& values, const Function& function) {
  std::vector<double> results(values.size());
  std::transform(values.begin(), values.end(), results.begin(), function);
  return results;
}

// Returns a function that computes rows of a field point by point.
template <typename Field>
FillRow pointwise(std::int32_t size, const Field& field) {
  return [at = coordinates(size), field](std::int32_t y, std::int32_t z, std::span<double> row) {
    for (std::size_t x = 0; x < row.size(); ++x) {
      row[x] = field(at[x], at[static_cast<std::size_t>(y)], at[static_cast<std::size_t>(z)]);
    }
  };
}

double sphere(double x, double y, double z) { return 0.75 - std::sqrt(x * x + y * y + z * z); }

double torus(double x, double y, double z) {
  const double ring = std::sqrt(x * x + y * y) - 0.6;
  return 0.25 - std::sqrt(ring * ring + z * z);
}

double box(double x, double y, double z) {
  const bool inside = std::abs(x) <= 0.5 && std::abs(y) <= 0.375 && std::abs(z) <= 0.25;
  return inside ? 255 : 0;
}

FillRow gyroid(std::int32_t size) {
  const std::vector<double> at = coordinates(size);  // One turn per unit: two periods per side.
  return [sine = mapped(at, sine_of_turns), cosine = mapped(at, cosine_of_turns)](
             std::int32_t j, std::int32_t k, std::span<double> row) {
    const auto y = static_cast<std::size_t>(j);
    const auto z = static_cast<std::size_t>(k);
    for (std::size_t x = 0; x < row.size(); ++x) {
      row[x] = sine[x] * cosine[y] + sine[y] * cosine[z] + sine[z] * cosine[x];
    }
  };
}

// (1 - sin(pi z / 2) + alpha (1 + cos(2 pi f_M cos(pi r / 2)))) / (2 (1 + alpha)), r^2 = x^2 + y^2.
// Computes the part that depends on r once for all slices.
FillRow marschner_lobb(std::int32_t size) {
  constexpr double kFrequency = 6;
  constexpr double kAlpha = 0.25;
  const std::vector<double> at = coordinates(size);
  std::vector<double> ripples(at.size() * at.size());
  in_parallel(at.size(), [&](std::size_t y) {
    for (std::size_t x = 0; x < at.size(); ++x) {
      const double radius = std::sqrt(at[x] * at[x] + at[y] * at[y]);
      const double phase = kFrequency * cosine_of_turns(radius / 4);
      ripples[x + at.size() * y] = kAlpha * (1 + cosine_of_turns(phase));
    }
  });
  const auto slope = mapped(at, [](double z) { return 1 - sine_of_turns(z / 4); });
  return [ripples, slope](std::int32_t y, std::int32_t z, std::span<double> row) {
    const double* const ripple = &ripples[row.size() * static_cast<std::size_t>(y)];
    for (std::size_t x = 0; x < row.size(); ++x) {
      row[x] = (slope[static_cast<std::size_t>(z)] + ripple[x]) / (2 * (1 + kAlpha));
    }
  };
}

FillRow head(std::int32_t size) {
  return [phantom = HeadPhantom(size)](std::int32_t y, std::int32_t z, std::span<double> row) {
    phantom.fill_row(y, z, row);
  };
}

FillRow rows_of(GeneratorKind kind, std::int32_t size) {
  switch (kind) {
    case GeneratorKind::kSphere:
      return pointwise(size, sphere);
    case GeneratorKind::kTorus:
      return pointwise(size, torus);
    case GeneratorKind::kGyroid:
      return gyroid(size);
    case GeneratorKind::kMarschnerLobb:
      return marschner_lobb(size);
    case GeneratorKind::kBox:
      return pointwise(size, box);
    case GeneratorKind::kHead:
      return head(size);
  }
  return {};
}

SampleType type_of(GeneratorKind kind) {
  if (kind == GeneratorKind::kBox) return SampleType::kU8;
  return kind == GeneratorKind::kHead ? SampleType::kI16 : SampleType::kF32;
}

class GeneratedVolume : public VolumeSource {
 public:
  GeneratedVolume(GeneratorKind kind, const GeneratorOptions& options)
      : header_{.dims = {options.size, options.size, options.size}, .type = type_of(kind)},
        options_(options),
        fill_row_(rows_of(kind, options.size)) {}

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    if (header_.type == SampleType::kU8) {
      fill<std::uint8_t>(first_slice, slices, into);
    } else if (header_.type == SampleType::kI16) {
      fill<std::int16_t>(first_slice, slices, into);
    } else {
      fill<float>(first_slice, slices, into);
    }
  }

 private:
  template <typename Sample>
  void fill(std::int32_t first_slice, std::int32_t slices, Samples& into) const {
    using Values = std::vector<Sample>;
    if (!std::holds_alternative<Values>(into)) into = Values();
    Values& samples = std::get<Values>(into);
    const auto size = static_cast<std::size_t>(options_.size);
    samples.resize(size * size * static_cast<std::size_t>(slices));
    in_parallel(static_cast<std::size_t>(slices), [&](std::size_t slice) {
      const std::size_t z = static_cast<std::size_t>(first_slice) + slice;
      std::vector<double> row(size);
      for (std::size_t y = 0; y < size; ++y) {
        fill_row_(static_cast<std::int32_t>(y), static_cast<std::int32_t>(z), row);
        const std::size_t first = size * (y + size * z);  // In the volume.
        Sample* const to = &samples[size * (y + size * slice)];
        for (std::size_t x = 0; x < size; ++x) {
          if (options_.noise > 0) row[x] += options_.noise * sample_noise(options_.seed, first + x);
          to[x] = sample_of<Sample>(row[x]);
        }
      }
    });
  }

  VolumeHeader header_;
  GeneratorOptions options_;
  FillRow fill_row_;
};

}  // namespace

std::string_view name(GeneratorKind kind) { return facts(kind).name; }

std::optional<GeneratorKind> generator_kind_from(std::string_view name_text) {
  for (const GeneratorKind kind : kGeneratorKinds) {
    if (name(kind) == name_text) return kind;
  }
  return std::nullopt;
}

double suggested_isovalue(GeneratorKind kind) { return facts(kind).isovalue; }

std::unique_ptr<VolumeSource> generated_volume(GeneratorKind kind,
                                               const GeneratorOptions& options) {
  if (options.size < 2 || options.size > kMaxSize) {
    throw std::invalid_argument("A generated volume must have 2 to " + std::to_string(kMaxSize) +
                                " samples a side, not " + std::to_string(options.size) + ".");
  }
  if (!std::isfinite(options.noise) || options.noise < 0) {
    throw std::invalid_argument(
        "The noise of a generated volume must be a finite number of at least 0, not " +
        std::to_string(options.noise) + ".");
  }
  return std::make_unique<GeneratedVolume>(kind, options);
}

Volume generate(GeneratorKind kind, const GeneratorOptions& options) {
  Volume volume;
  volume.dims = {options.size, options.size, options.size};
  volume.samples = generated_volume(kind, options)->take_all();
  return volume;
}

}  // namespace multitetra

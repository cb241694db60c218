// Volumes from formulas, whose isosurfaces are known: for tests, benchmarks and demonstrations.
//
// Guaranteed: the same kind and options give the same bits on every machine, for any thread count.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "server/core/framework/volume.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Samples fill the cube [-1, 1]^3, both ends included, unless noted otherwise.
enum class GeneratorKind {
  // f32: 0.75 - |p|. Isovalue 0 is the sphere of radius 0.75.
  kSphere,
  // f32: 0.25 - sqrt((sqrt(x^2 + y^2) - 0.6)^2 + z^2). Isovalue 0 is the torus of radii 0.6, 0.25.
  kTorus,
  // f32: sin X cos Y + sin Y cos Z + sin Z cos X, two periods per side. Isovalue 0 approximates the
  // gyroid: A. Schoen, "Infinite Periodic Minimal Surfaces without Self-Intersections", NASA TN
  // D-5541, 1970.
  kGyroid,
  // f32: the test signal of S. Marschner and R. Lobb, "An Evaluation of Reconstruction Filters for
  // Volume Rendering", IEEE Visualization 1994, with f_M = 6 and alpha = 0.25. Isovalue 0.5.
  kMarschnerLobb,
  // u8: 255 within the box |x| <= 1/2, |y| <= 3/8, |z| <= 1/4, 0 elsewhere: a voxelized box as in
  // Zhou, Chen and Kaufman 1997, whose flat faces fuse into few tetrahedra. Isovalue 127.5.
  kBox,
  // i16, like the Hounsfield units of a CT scan: the Shepp-Logan head of ten ellipsoids. Isovalue
  // 500.5 is the skull's outside and inside, 100.5 shows the ventricles too; see head_phantom.hpp.
  kHead,
};

inline constexpr std::array kGeneratorKinds = {
    GeneratorKind::kSphere,        GeneratorKind::kTorus, GeneratorKind::kGyroid,
    GeneratorKind::kMarschnerLobb, GeneratorKind::kBox,   GeneratorKind::kHead};

// "sphere", "torus", "gyroid", "marschner-lobb", "box", "head"
[[nodiscard]] std::string_view name(GeneratorKind kind);
[[nodiscard]] std::optional<GeneratorKind> generator_kind_from(std::string_view name);

// Returns the isovalue that the kind's description names first.
[[nodiscard]] double suggested_isovalue(GeneratorKind kind);

struct GeneratorOptions {
  std::int32_t size = 64;  // Samples per side, 2 to 4097.
  // Standard deviation of the noise added to each sample, in units of the sample, >= 0. The noise
  // is nearly normal (the sum of twelve uniform numbers). Integer samples are rounded and clamped.
  double noise = 0;
  std::uint64_t seed = 1;  // Seed of the noise.
};

// Returns a volume with spacing 1 and the origin at the first sample, which computes slices when
// they are read. Throws std::invalid_argument, naming the option and its range, if an option is out
// of range.
[[nodiscard]] std::unique_ptr<VolumeSource> generated_volume(GeneratorKind kind,
                                                             const GeneratorOptions& options);

// Returns all its samples.
[[nodiscard]] Volume generate(GeneratorKind kind, const GeneratorOptions& options);

}  // namespace multitetra

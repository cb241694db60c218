// The physical meaning of a dataset's numbers: the anatomical directions of the world axes, the
// units of lengths and values, and what of the placement is known. For information only: nothing is
// converted.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace multitetra {

// The anatomical directions of the world axes: x, y, z grow to the Left, Posterior, Superior (LPS),
// or to the Right, Anterior, Superior (RAS). Unnamed: the file's own axes.
enum class WorldSpace { kUnnamed, kLps, kRas };

[[nodiscard]] std::string_view name(WorldSpace space);  // "", "LPS", "RAS"
[[nodiscard]] std::optional<WorldSpace> world_space_from(std::string_view name);

// How much of the placement (spacing, origin) the source of the samples states: all of it, a part,
// or nothing. Spacings that it does not state are assumed to be 1, coordinates of the first sample
// 0. Unknown for generated volumes and for datasets of earlier versions.
enum class GeometryBasis { kUnknown, kStated, kPartly, kAssumed };

[[nodiscard]] std::string_view name(GeometryBasis basis);  // "", "stated", "partly", "assumed"
[[nodiscard]] std::optional<GeometryBasis> geometry_basis_from(std::string_view name);

struct PhysicalMeaning {
  WorldSpace space = WorldSpace::kUnnamed;
  // The unit of spacing and world coordinates, such as "mm"; empty: unknown.
  std::string length_unit = {};
  // The unit of samples and isovalues, such as "HU"; empty: unknown.
  std::string value_unit = {};
  GeometryBasis geometry = GeometryBasis::kUnknown;
  // What of the placement is assumed, such as "spacing along z, origin"; same rules as units.
  std::string assumed = {};
  // Rounding of samples to 32-bit floats that changes them by more than a ten-thousandth of their
  // range, such as "up to 0.06, 0.5 % of their range"; same rules as units. Empty: less, or
  // unknown.
  std::string rounding = {};

  friend bool operator==(const PhysicalMeaning&, const PhysicalMeaning&) = default;
};

inline constexpr std::size_t kMaxUnitBytes = 64;

// Returns the basis with what is assumed: "partly (spacing along z is assumed)"; empty if unknown.
[[nodiscard]] std::string geometry_text(const PhysicalMeaning& meaning);

// Returns the sentence about rounding of the samples of `source`, which is quoted; empty if none is
// stated.
[[nodiscard]] std::string rounding_text(const std::string& source, const PhysicalMeaning& meaning);

// Returns whether a spacing is assumed, so that lengths in world units are not those of the object.
[[nodiscard]] inline bool has_assumed_spacing(const PhysicalMeaning& meaning) {
  return meaning.assumed.starts_with("spacing");
}

// Returns whether a text is a valid unit: UTF-8, at most kMaxUnitBytes, no control characters.
[[nodiscard]] bool is_unit_text(std::string_view text);

}  // namespace multitetra

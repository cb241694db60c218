// The physical meaning of a dataset's numbers: the anatomical directions of the world axes, and the
// units of lengths and values. For information only: nothing is converted.
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

struct PhysicalMeaning {
  WorldSpace space = WorldSpace::kUnnamed;
  // The unit of spacing and world coordinates, such as "mm"; empty: unknown.
  std::string length_unit;
  // The unit of samples and isovalues, such as "HU"; empty: unknown.
  std::string value_unit;

  friend bool operator==(const PhysicalMeaning&, const PhysicalMeaning&) = default;
};

inline constexpr std::size_t kMaxUnitBytes = 64;

// Returns whether a text is a valid unit: UTF-8, at most kMaxUnitBytes, no control characters.
[[nodiscard]] bool is_unit_text(std::string_view text);

}  // namespace multitetra

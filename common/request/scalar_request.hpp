// The values of a field at the vertices of a surface, to color it: which field, and how they are
// rounded to codes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.hpp"
#include "common/request/dataset_info.hpp"

namespace multitetra {

inline constexpr int kDefaultScalarBits = 16;

// The encoding of values as codes: low + code * step, the largest code for no value (NaN). So a
// value within the range is off by half a step at most, and what is beyond has the code of the end.
struct ScalarRange {
  double low = 0;                 // Finite.
  double high = 0;                // Finite, >= low.
  int bits = kDefaultScalarBits;  // 8 or 16.

  [[nodiscard]] std::uint32_t no_value() const { return (std::uint32_t{1} << bits) - 1; }
  [[nodiscard]] double step() const { return (high - low) / static_cast<double>(no_value() - 1); }
  [[nodiscard]] std::uint32_t code_of(double value) const;
  [[nodiscard]] float value_of(std::uint32_t code) const;

  friend bool operator==(const ScalarRange&, const ScalarRange&) = default;
};

struct ScalarRequest {
  std::string dataset = {};
  int bits = kDefaultScalarBits;  // 8 or 16.
  struct Limits {
    double low = 0;  // Finite, below high.
    double high = 1;
    friend bool operator==(const Limits&, const Limits&) = default;
  };
  std::optional<Limits> limits = {};  // None: those of the dataset's samples.

  friend bool operator==(const ScalarRequest&, const ScalarRequest&) = default;
};

// kInvalidArgument, naming the field and its range, unless every field is within it.
[[nodiscard]] Result<ScalarRequest> validated(const ScalarRequest& request);

[[nodiscard]] ScalarRange range_for(const ScalarRequest& request, const DatasetInfo& field);

// kInvalidArgument if the two datasets are in different worlds: their space and unit must agree
// where both are known.
[[nodiscard]] Result<void> check_same_world(const DatasetInfo& surface, const DatasetInfo& field);

}  // namespace multitetra

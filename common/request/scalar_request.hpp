// The values of a field at the vertices of a surface, to color it: the requested field, and the
// encoding of its values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"

namespace multitetra {

inline constexpr int kDefaultScalarBits = 16;

// Encodes values as codes: value = low + code * step, the largest code for no value (NaN). Values
// in the range are off by at most half a step; others have the code of the nearest end.
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
    double low = 0;  // Finite, less than high.
    double high = 1;
    friend bool operator==(const Limits&, const Limits&) = default;
  };
  std::optional<Limits> limits = {};  // Absent: the range of the dataset's samples.
  // Allows a dataset in another world than the surface's.
  bool in_any_world = false;

  friend bool operator==(const ScalarRequest&, const ScalarRequest&) = default;
};

// Returns the request, or kInvalidArgument, naming the field out of range and its range.
[[nodiscard]] Result<ScalarRequest> validated(const ScalarRequest& request);

[[nodiscard]] ScalarRange range_for(const ScalarRequest& request, const DatasetInfo& field);

// Fails with kInvalidArgument and the reason if the datasets lie in different worlds (see
// world_mismatch()), unless the request allows that.
[[nodiscard]] Result<void> check_same_world(const ScalarRequest& request,
                                            const DatasetInfo& surface, const DatasetInfo& field);

}  // namespace multitetra

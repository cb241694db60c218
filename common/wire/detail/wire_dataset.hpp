// Converts dataset descriptions to and from protobuf.
#pragma once

#include "common/dataset/dataset_info.hpp"
#include "common/wire/detail/wire_checks.hpp"
#include "multitetra/v1/dataset.pb.h"

namespace multitetra::wire {

inline constexpr std::int32_t kMaxGridExponent = kMaxLatticeBits - kMinLatticeResolution;
inline constexpr std::uint64_t kMaxGridSteps = std::uint64_t{1} << kMaxGridExponent;

void write_dataset(const DatasetInfo& info, v1::DatasetInfo& wire);
[[nodiscard]] DatasetInfo read_dataset(const v1::DatasetInfo& wire, FieldChecks& checks);

}  // namespace multitetra::wire

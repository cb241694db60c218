// The metadata that are computed from the samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"

namespace multitetra {

struct SampleFacts {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::uint64_t void_samples = 0;

  // Adds samples of type `type`.
  void add(SampleType type, std::span<const std::byte> bytes);
};

// Returns kDamagedData if `facts` differ from the metadata.
[[nodiscard]] Result<void> check_facts(const DatasetInfo& info, SampleFacts facts);

}  // namespace multitetra

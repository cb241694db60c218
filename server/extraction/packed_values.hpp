// Sample values packed for sending: a half to a twentieth of the bytes of floats. The format is
// that of SliceReply.packed_type in proto/multitetra/v1/conversation.proto.
#pragma once

#include <span>
#include <string>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

struct PackedValues {
  SampleType type = SampleType::kF32;
  std::string bytes = {};  // A zlib stream.
};

// Packs values as numbers of `type` if it holds all of them exactly, else as floats.
[[nodiscard]] PackedValues packed_values(std::span<const float> values, SampleType type);

}  // namespace multitetra

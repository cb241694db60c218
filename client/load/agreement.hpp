// Checks that all clients receive identical steps: a step is a pure function of its dataset and
// parameters.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "common/wire/messages.hpp"

namespace multitetra {

class Agreement {
 public:
  enum class Verdict { kNew, kSame, kDifferent };

  // Compares with the digest recorded before, by any thread, for the same step.
  Verdict compare(const std::string& dataset, const StepBegin& begin, const ContentDigest& digest);

 private:
  static constexpr std::size_t kMaxSteps = 1 << 20;
  std::mutex mutex_;  // Guards digests_.
  std::map<std::string, ContentDigest> digests_;
};

}  // namespace multitetra

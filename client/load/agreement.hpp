// Checks that all clients receive the same steps: a step is a pure function of its dataset and its
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
  enum class Verdict { kNew, kSame, kAnother };

  // Compares with the digest that any thread recorded for the same step before.
  Verdict compare(const std::string& dataset, const StepBegin& begin, const ContentDigest& digest);

 private:
  static constexpr std::size_t kMaxSteps = 1 << 20;
  std::mutex mutex_;  // Guards the map.
  std::map<std::string, ContentDigest> digests_;
};

}  // namespace multitetra

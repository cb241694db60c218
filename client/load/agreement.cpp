#include "client/load/agreement.hpp"

namespace multitetra {

Agreement::Verdict Agreement::compare(const std::string& dataset, const StepBegin& begin,
                                      const ContentDigest& digest) {
  // The bytes of a request for this very step name it.
  std::string step =
      serialize(OpenStream{.request_id = static_cast<std::uint64_t>(begin.finest_spacing),
                           .dataset = dataset,
                           .request = begin.request,
                           .held = {}});
  const std::lock_guard lock(mutex_);
  const auto known = digests_.find(step);
  if (known != digests_.end()) {
    return known->second == digest ? Verdict::kSame : Verdict::kAnother;
  }
  if (digests_.size() < kMostSteps) digests_.emplace(std::move(step), digest);
  return Verdict::kNew;
}

}  // namespace multitetra

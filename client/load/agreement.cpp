#include "client/load/agreement.hpp"

namespace multitetra {

Agreement::Verdict Agreement::compare(const std::string& dataset, const StepBegin& begin,
                                      const ContentDigest& digest) {
  // A serialized request for exactly this step serves as its key.
  std::string step =
      serialize(OpenStream{.request_id = 1,
                           .dataset = dataset,
                           .request = begin.request,
                           .cached_tile_digests = {},
                           .resumed_previews = {{.finest_spacing = begin.finest_spacing,
                                                 .is_unsimplified = begin.is_unsimplified}}});
  const std::lock_guard lock(mutex_);
  const auto known = digests_.find(step);
  if (known != digests_.end()) {
    return known->second == digest ? Verdict::kSame : Verdict::kDifferent;
  }
  if (digests_.size() < kMaxSteps) digests_.emplace(std::move(step), digest);
  return Verdict::kNew;
}

}  // namespace multitetra

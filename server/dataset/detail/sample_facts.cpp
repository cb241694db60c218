#include "server/dataset/detail/sample_facts.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "server/dataset/prepared_format.hpp"

namespace multitetra {
namespace {

template <typename Sample>
void add_samples(SampleFacts& facts, std::span<const std::byte> bytes) {
  for (; bytes.size() >= sizeof(Sample); bytes = bytes.subspan(sizeof(Sample))) {
    Sample sample{};
    std::memcpy(&sample, bytes.data(), sizeof(Sample));
    const auto value = static_cast<double>(sample);
    if (std::isnan(value)) {
      ++facts.void_samples;
      continue;
    }
    facts.min = std::min(facts.min, value);
    facts.max = std::max(facts.max, value);
  }
}

}  // namespace

void SampleFacts::add(SampleType type, std::span<const std::byte> bytes) {
  visit_type(type, [&]<typename Sample>(const Sample*) { add_samples<Sample>(*this, bytes); });
}

Result<void> check_facts(const DatasetInfo& info, SampleFacts facts) {
  if (facts.min > facts.max) facts.min = facts.max = 0;  // All samples are void.
  if (facts.min == info.min && facts.max == info.max && facts.void_samples == info.void_samples) {
    return {};
  }
  return damaged(section_names::kMetadata,
                 "the metadata declare samples from " + std::to_string(info.min) + " to " +
                     std::to_string(info.max) + " and " + std::to_string(info.void_samples) +
                     " void samples; the samples range from " + std::to_string(facts.min) + " to " +
                     std::to_string(facts.max) + " and " + std::to_string(facts.void_samples) +
                     " are void.");
}

}  // namespace multitetra

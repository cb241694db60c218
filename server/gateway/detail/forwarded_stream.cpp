#include "server/gateway/detail/forwarded_stream.hpp"

#include <span>
#include <string_view>

#include "common/mesh/checksum.hpp"

namespace multitetra {
namespace {

std::uint64_t sum_of(std::string_view bytes) {
  return checksum(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

std::uint64_t identity_of(const ServerMessage& message) {
  if (const auto* tile = std::get_if<Tile>(&message)) {
    return sum_of(*tile->payload) * 31 + tile->index * 7 + tile->step;
  }
  if (const auto* end = std::get_if<StepEnd>(&message)) {
    StepEnd timeless = *end;
    timeless.seconds = 0;
    return sum_of(serialize(timeless));
  }
  return sum_of(serialize(message));
}

}  // namespace

ForwardedStream::Verdict ForwardedStream::next(const ServerMessage& message) {
  const std::uint64_t identity = identity_of(message);
  if (position_ < forwarded_.size()) {
    return forwarded_[position_++] == identity ? Verdict::kSkip : Verdict::kDiffers;
  }
  if (const auto* begin = std::get_if<StepBegin>(&message)) {
    step_ = *begin;
    if (!record_started_step(*begin, open_)) return Verdict::kDiffers;
  }
  forwarded_.push_back(identity);
  ++position_;
  return Verdict::kForward;
}

}  // namespace multitetra

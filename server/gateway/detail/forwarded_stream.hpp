// The part of a stream that a client has received, so that another server can continue it: the same
// request has the same answer everywhere, so what was forwarded already is skipped the second time.
// Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/wire/messages.hpp"

namespace multitetra {

class ForwardedStream {
 public:
  explicit ForwardedStream(OpenStream open) : open_(std::move(open)) {}

  // The request to send to an upstream, for the first time or again: it contains what was received
  // already.
  [[nodiscard]] const OpenStream& open() const { return open_; }
  // Another server begins from the start.
  void restart() { position_ = 0; }

  enum class Verdict {
    kForward,  // The client has not seen it.
    kPassOver,
    kDiffers,  // It differs from what the client has received: the stream ends.
  };
  // The next message of the stream: StepBegin, Tile or StepEnd.
  [[nodiscard]] Verdict next(const ServerMessage& message);

  [[nodiscard]] std::uint32_t steps_ended() const { return steps_ended_; }
  // The step that is being sent to the client.
  [[nodiscard]] const StepBegin& step() const { return step_; }

 private:
  OpenStream open_;
  std::vector<std::uint64_t> forwarded_;  // A checksum of each message, times left out.
  std::size_t position_ = 0;
  std::uint32_t steps_ended_ = 0;
  StepBegin step_;
};

}  // namespace multitetra

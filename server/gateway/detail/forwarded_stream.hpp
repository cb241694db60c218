// Tracks what a client has received of a stream, so that another server can continue it. Equal
// requests have equal answers on every server, so the part already forwarded is skipped. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/wire/messages.hpp"

namespace multitetra {

class ForwardedStream {
 public:
  explicit ForwardedStream(OpenStream open) : open_(std::move(open)) {}

  // Returns the request to send to an upstream, first or again. It includes what the client already
  // has.
  [[nodiscard]] const OpenStream& open() const { return open_; }
  // Another server starts the stream from the beginning.
  void restart() { position_ = 0; }

  enum class Verdict {
    kForward,  // New to the client.
    kSkip,
    kDiffers,  // Differs from what the client has received, or follows from no request; ends the
               // stream.
  };
  // Classifies the next message: StepBegin, Tile or StepEnd.
  [[nodiscard]] Verdict next(const ServerMessage& message);

  // Returns the step that is being sent to the client.
  [[nodiscard]] const StepBegin& step() const { return step_; }

 private:
  OpenStream open_;
  std::vector<std::uint64_t> forwarded_;  // One checksum per message, without times.
  std::size_t position_ = 0;
  StepBegin step_;
};

}  // namespace multitetra

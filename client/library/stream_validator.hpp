// Checks one stream as far as possible without decoding: the order of messages, every manifest
// against the request and the limits, all counts, and the sum of the digests of a step's tiles.
//
//   StreamValidator validator(info, open, held);
//   Result<bool> accepted = validator.accept(message);   // false: it belongs to another request
//
// Nothing that the server sends is trusted. A failed check is an error that names the step and, if
// it concerns one, the tile; the validator must not be used afterwards.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "common/wire/messages.hpp"

namespace multitetra {

// Limits what one stream can make the client store, over all steps: tiles are kept until the stream
// ends, because the server does not send them again. A tile of several steps counts once. One step,
// including tiles held before, must also fit within these limits.
struct AssemblerLimits {
  std::uint32_t steps = 64;
  std::uint64_t tiles = 1 << 20;
  std::uint64_t triangles = 400'000'000;
  std::uint64_t payload_bytes = std::uint64_t{4} << 30;
};

// Sums over the tiles of a manifest.
struct ManifestTotals {
  std::uint64_t tiles = 0;
  std::uint64_t triangles = 0;
  std::uint64_t payload_bytes = 0;

  void add(const TileSummary& tile);
};

class StreamValidator {
 public:
  // `held`: the cached tiles that `open` names.
  StreamValidator(DatasetInfo info, OpenStream open, std::set<ContentDigest> held,
                  AssemblerLimits limits = {});

  // Returns whether the message belongs to this stream; if so, it has passed all checks.
  [[nodiscard]] Result<bool> accept(const ServerMessage& message);

  // Returns the step that began last. Requires that one has begun.
  [[nodiscard]] const StepBegin& step() const { return *step_; }
  // Returns the digests of the tiles that were held or received.
  [[nodiscard]] const std::set<ContentDigest>& held() const { return held_; }
  // Whether each step is the preview of another dataset.
  [[nodiscard]] bool is_of_several() const { return !open_.further_datasets.empty(); }

 private:
  Result<bool> take(const StepBegin& begin);
  Result<bool> take(const Tile& tile);
  Result<bool> take(const TileScalars& scalars);
  Result<bool> take(const StepEnd& end);
  Result<bool> take(const StreamEnd& end);
  Result<bool> take(const ErrorReply& reply);
  template <typename Other>
  Result<bool> take(const Other&) {
    // Messages about the connection, or replies to requests other than streams.
    return false;
  }

  DatasetInfo info_;
  OpenStream open_;
  AssemblerLimits limits_;
  std::set<ContentDigest> held_;
  std::optional<StepBegin> step_;
  bool is_step_open_ = false;
  std::uint32_t tiles_received_ = 0;
  std::uint64_t bytes_received_ = 0;
  std::uint32_t steps_ended_ = 0;
  // The announced tiles of all steps so far, without those held.
  ManifestTotals announced_;
  bool has_ended_ = false;
};

}  // namespace multitetra

// Checks one stream, thoroughly or cheaply.
//
// Thorough checks use Assembler: every tile is decoded, every step welded and its topology
// compared. Cheap checks use StreamValidator only; a sample of the tiles is decoded and nothing is
// welded. A load generator that checked everything for a thousand clients would measure itself.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "client/library/assembler.hpp"

namespace multitetra {

// A step is complete.
struct WholeStep {
  StepBegin begin;
  ContentDigest digest;
};
using StreamProgress = std::variant<std::monostate, WholeStep, StreamEnd, Refusal>;

class StreamChecks {
 public:
  static StreamChecks thorough(DatasetInfo info, OpenStream open, CachedTiles held);
  // Decodes one in `tiles_per_decoded` tiles, selected by digest; 0: none.
  static StreamChecks cheap(DatasetInfo info, OpenStream open, std::uint32_t tiles_per_decoded);

  // Returns an error for a failed check.
  [[nodiscard]] Result<StreamProgress> receive(const ServerMessage& message);

  // Returns the same checks for a request resumed by `open`, which must name held_digests().
  [[nodiscard]] StreamChecks resumed(const DatasetInfo& info, const OpenStream& open) const;
  [[nodiscard]] std::vector<ContentDigest> held_digests() const;
  [[nodiscard]] std::uint64_t tiles_decoded() const { return tiles_decoded_; }
  [[nodiscard]] bool is_thorough() const { return std::holds_alternative<Assembler>(checks_); }

 private:
  explicit StreamChecks(std::variant<Assembler, StreamValidator> checks, std::uint32_t sampling)
      : checks_(std::move(checks)), tiles_per_decoded_(sampling) {}

  Result<StreamProgress> receive(StreamValidator& validator, const ServerMessage& message);
  Result<StreamProgress> receive(Assembler& assembler, const ServerMessage& message);

  std::variant<Assembler, StreamValidator> checks_;
  std::uint32_t tiles_per_decoded_ = 0;
  std::uint64_t tiles_decoded_ = 0;
};

}  // namespace multitetra

// Checks of one stream, thorough or cheap.
//
// Thorough is the assembler: every tile decoded, every step welded and its topology compared. Cheap
// is the ledger: the manifests, the order of things, all counts and sums of digests, as the
// assembler has them; of the tiles only a sample is decoded, and nothing is welded. A load
// generator that does everything for each of a thousand clients would measure itself.
#pragma once

#include <cstdint>
#include <set>
#include <variant>
#include <vector>

#include "client/assembler.hpp"

namespace multitetra {

// A step has come whole.
struct StepIsWhole {
  StepBegin begin;
  ContentDigest digest;
};
using StreamProgress = std::variant<std::monostate, StepIsWhole, StreamEnd, Refusal>;

class StreamLedger {
 public:
  // One tile of `tiles_per_decoded`, by its digest, is decoded; 0: none.
  StreamLedger(DatasetInfo info, OpenStream open, std::uint32_t tiles_per_decoded,
               AssemblerLimits limits = {});

  // An error is a failed check; after it the ledger is of no use.
  [[nodiscard]] Result<StreamProgress> receive(const ServerMessage& message);

  // That came, and those that the request named.
  [[nodiscard]] const std::set<ContentDigest>& held() const { return held_; }
  [[nodiscard]] std::uint64_t tiles_decoded() const { return tiles_decoded_; }

 private:
  Result<StreamProgress> take(const StepBegin& begin);
  Result<StreamProgress> take(const Tile& tile);
  Result<StreamProgress> take(const StepEnd& end);
  Result<StreamProgress> take(const StreamEnd& end);
  Result<StreamProgress> take(const ErrorReply& reply);
  template <typename Other>
  Result<StreamProgress> take(const Other&) {
    return StreamProgress{};
  }

  DatasetInfo info_;
  OpenStream open_;
  std::uint32_t tiles_per_decoded_;
  AssemblerLimits limits_;
  std::set<ContentDigest> held_;
  std::optional<StepBegin> begun_;
  std::uint32_t tiles_received_ = 0;  // Of the step.
  std::uint64_t bytes_received_ = 0;  // Of the step.
  std::uint32_t steps_ = 0;
  bool has_final_ = false;
  std::uint64_t tiles_decoded_ = 0;
};

// Either, behind one face.
class StreamChecks {
 public:
  static StreamChecks thorough(DatasetInfo info, OpenStream open, HeldTiles held);
  static StreamChecks cheap(DatasetInfo info, OpenStream open, std::uint32_t tiles_per_decoded);

  [[nodiscard]] Result<StreamProgress> receive(const ServerMessage& message);

  // The same checks for the same request after a lost connection: `open` must name held_digests().
  [[nodiscard]] StreamChecks again(const DatasetInfo& info, const OpenStream& open) const;
  [[nodiscard]] std::vector<ContentDigest> held_digests() const;
  [[nodiscard]] std::uint64_t tiles_decoded() const;
  [[nodiscard]] bool is_thorough() const { return std::holds_alternative<Assembler>(checks_); }

 private:
  explicit StreamChecks(std::variant<Assembler, StreamLedger> checks, std::uint32_t sampling)
      : checks_(std::move(checks)), tiles_per_decoded_(sampling) {}

  std::variant<Assembler, StreamLedger> checks_;
  std::uint32_t tiles_per_decoded_ = 0;
  std::uint64_t tiles_thoroughly_decoded_ = 0;
};

}  // namespace multitetra

// Server messages in, complete and checked steps out. Pure: no socket, no clock, no file.
//
//   Assembler assembler(info, open);
//   Result<Progress> progress = assembler.receive(message);
//
// What it gives is never torn: a step is handed out only when all its tiles are there and every
// check has passed; until then the step before stays shown. Checked are: the manifest against the
// request and the limits, before anything is allocated for it; each tile against the manifest; the
// totals and the digest of the step; that the welded mesh is sound, its edges shared by two
// triangles everywhere but on the data's border; and that all steps which preserve the topology
// have the same Euler characteristic and number of components.
//
// Nothing that the server sends is trusted. A failed check is an Error that names the step and, if
// it concerns one, the tile; from then on the assembler returns that error only.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

// Decoded tiles by their content, for use in later steps and streams.
using HeldTiles = std::map<ContentDigest, std::shared_ptr<const LatticeMesh>>;

// What one stream may ask the client to hold, all steps together: a tile is kept until the stream
// has ended, because the server does not send it again. A tile in several steps counts once. The
// same limits hold for one step with the tiles that are held already.
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

// A step that passed all checks.
struct CommittedStep {
  StepBegin begin;
  StepEnd end;
  LatticeMesh mesh;  // Welded, of all tiles.
  MeshTopology topology;
  std::vector<std::string> checks;  // Names of the checks that it passed.
  // Of its scalars, as TileScalars tells it, without rounding to codes; 0 without scalars.
  double largest_scalar_deviation = 0;
};
// Whether the step promises the topology of the full-resolution surface.
[[nodiscard]] bool preserves_topology(const StepBegin& begin);
using CommittedStepPtr = std::shared_ptr<const CommittedStep>;

// The server refuses or gives up the stream. That is no failed check.
struct Refusal {
  Error error;
};

// What a message led to: nothing to show yet (or it concerns another stream), a new step to show,
// or an end.
using Progress = std::variant<std::monostate, CommittedStepPtr, StreamEnd, Refusal>;

class Assembler {
 public:
  // Of `held` those are used that `open` tells the server not to send; the server sends the others.
  Assembler(DatasetInfo info, OpenStream open, HeldTiles held = {}, AssemblerLimits limits = {});

  [[nodiscard]] Result<Progress> receive(const ServerMessage& message);

  // The step to show: the last that was committed, null before the first.
  [[nodiscard]] const CommittedStepPtr& shown() const { return shown_; }
  // All tiles that need not be sent again, those of an unfinished step included: what a repeated
  // request may name as held after a lost connection.
  [[nodiscard]] const HeldTiles& held() const { return held_; }

 private:
  struct PendingStep;
  struct Invariants {
    std::uint32_t step = 0;  // That had them first.
    std::int64_t euler_characteristic = 0;
    std::int64_t components = 0;
  };

  Result<Progress> take(const StepBegin& begin);
  Result<Progress> take(const Tile& tile);
  Result<Progress> take(const TileScalars& scalars);
  Result<Progress> take(const StepEnd& end);
  Result<Progress> take(const StreamEnd& end);
  Result<Progress> take(const ErrorReply& reply);
  template <typename Other>
  Result<Progress> take(const Other&);

  // The tiles of the pending step as one mesh, with their scalars if it has some.
  [[nodiscard]] Result<LatticeMesh> welded_step() const;
  [[nodiscard]] double largest_deviation() const;  // Of the scalars of the pending step.
  [[nodiscard]] std::optional<std::string> topology_fault(const StepBegin& begin,
                                                          const MeshTopology& topology);

  DatasetInfo info_;
  OpenStream open_;
  AssemblerLimits limits_;
  struct TileValues {
    std::vector<float> values;
    double largest_deviation = 0;
  };
  HeldTiles held_;
  std::map<ContentDigest, TileValues> scalars_;  // That came in this stream.
  CommittedStepPtr shown_;
  std::shared_ptr<PendingStep> pending_;
  std::uint32_t steps_committed_ = 0;
  ManifestTotals announced_;              // Of the tiles of all steps so far that were not held.
  std::optional<Invariants> invariants_;  // Of the steps that preserve the topology.
  bool has_ended_ = false;
  std::optional<Error> failed_;
};

}  // namespace multitetra

// Server messages in, complete and checked steps out. Pure: no socket, no clock, no file.
//
//   Assembler assembler(info, open);
//   Result<Progress> progress = assembler.receive(message);
//
// A step is returned only when all its tiles have arrived and every check has passed; until then
// the previous step stays shown, so no state has a crack. The checks: those of StreamValidator
// (order, manifest, counts, digests); each tile against the manifest; that the welded mesh is
// sound, its edges shared by two triangles everywhere but on the data's border; and that all steps
// which preserve the topology have the same Euler characteristic and number of components.
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

#include "client/library/stream_validator.hpp"
#include "common/mesh/merged_tiles.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {

// Decoded tiles by their content, for use in later steps and streams.
using HeldTiles = std::map<ContentDigest, std::shared_ptr<const LatticeMesh>>;

// A step that passed all checks.
struct CommittedStep {
  StepBegin begin;
  StepEnd end;
  LatticeMesh mesh;  // Welded, of all tiles.
  MeshTopology topology;
  std::vector<std::string> checks;  // Names of the checks that it passed.
  // The largest TileScalars::largest_deviation of its tiles; 0 without scalars.
  double largest_scalar_deviation = 0;
};
// Whether the step promises the topology of the full-resolution surface.
[[nodiscard]] bool preserves_topology(const StepBegin& begin);
// The largest distance to the full-resolution surface, in world units, before vertices are snapped
// to the lattice. None for previews, for the paper's error, and where features may vanish.
[[nodiscard]] std::optional<double> distance_bound(const StepBegin& begin);
// The same for the mesh as it is sent. Snapping moves a vertex by at most half a lattice step along
// an edge of a tetrahedron, of which a cell's longest diagonal is the longest.
[[nodiscard]] std::optional<double> mesh_distance_bound(const StepBegin& begin,
                                                        const DatasetInfo& info);
// Whether the step's mesh is the full-resolution surface, with vertices on the lattice: only then
// is its area that surface's, as no distance bounds an area.
[[nodiscard]] bool is_full_resolution(const StepBegin& begin);
using CommittedStepPtr = std::shared_ptr<const CommittedStep>;

// The server refused or ended the stream with an error, which is not a failed check.
struct Refusal {
  Error error;
};

// What a message led to: nothing to show yet (or it concerns another stream), a new step to show,
// or an end.
using Progress = std::variant<std::monostate, CommittedStepPtr, StreamEnd, Refusal>;

class Assembler {
 public:
  // Uses the tiles of `held` that `open` names; the server sends the others.
  Assembler(DatasetInfo info, OpenStream open, HeldTiles held = {}, AssemblerLimits limits = {});

  [[nodiscard]] Result<Progress> receive(const ServerMessage& message);

  // The step to show: the last that was committed, null before the first.
  [[nodiscard]] const CommittedStepPtr& shown() const { return shown_; }
  // All tiles that need not be sent again, those of an unfinished step included as far as they are
  // decoded: what a repeated request may name as held after a lost connection.
  [[nodiscard]] const HeldTiles& held() const { return held_; }
  // Sample shells are decoded many at a time, on all threads: decodes those that still wait.
  [[nodiscard]] Result<void> decode_waiting();

 private:
  struct Invariants {
    std::uint32_t step = 0;  // The step that contained them first.
    std::int64_t euler_characteristic = 0;
    std::int64_t components = 0;
  };

  using TilePtr = std::shared_ptr<const LatticeMesh>;

  // For messages that StreamValidator has accepted.
  Result<Progress> take(const StepBegin& begin);
  Result<Progress> take(const Tile& tile);
  Result<Progress> take(const TileScalars& scalars);
  Result<Progress> take(const StepEnd& end);
  Result<Progress> take(const StreamEnd& end) { return end; }
  Result<Progress> take(const ErrorReply& reply) { return Refusal{reply.error}; }
  template <typename Other>
  Result<Progress> take(const Other&) {
    return Progress{};
  }

  // The tiles of the pending step as one mesh, with their scalars if it has some.
  [[nodiscard]] Result<LatticeMesh> welded_step() const;
  // The same of sample shells, and its topology.
  [[nodiscard]] MergedTiles joined_step(const DataBorder& border) const;
  // The largest deviation of the pending step's scalars.
  [[nodiscard]] double largest_deviation() const;
  [[nodiscard]] std::optional<std::string> topology_fault(const StepBegin& begin,
                                                          const MeshTopology& topology);

  // A sample shell that has what was promised of it.
  struct WaitingTile {
    std::uint32_t index = 0;
    std::shared_ptr<const std::string> payload;
  };

  struct TileValues {
    std::vector<float> values;
    double largest_deviation = 0;
  };

  DatasetInfo info_;
  HeldTiles held_;
  StreamValidator validator_;
  std::vector<TilePtr> tiles_;  // Of the step; null: not there yet.
  // The boxes of tiles that were marched by this assembler; not of cached tiles.
  std::vector<std::optional<MarchedBox>> marched_;
  std::vector<WaitingTile> waiting_;  // Of the step.
  std::uint64_t waiting_triangles_ = 0;
  std::map<ContentDigest, TileValues> scalars_;  // Received in this stream.
  CommittedStepPtr shown_;
  // For the steps that preserve the topology.
  std::optional<Invariants> invariants_;
  std::optional<Error> failed_;
};

}  // namespace multitetra

// Assembles server messages into complete, checked steps. Pure: no socket, clock or file.
//
//   Assembler assembler(info, open);
//   Result<AssemblyEvent> progress = assembler.receive(message);
//
// A step is returned only after all its tiles have arrived and every check has passed; until then
// the previous step stays shown, so no state has a crack. The checks are those of StreamValidator
// (order, manifest, counts, digests), and: each tile matches the manifest; every edge of the welded
// mesh has two triangles, except on the data's border; all steps that preserve the topology have
// the same Euler characteristic and number of components. With further datasets, each step is the
// preview of another one, on the grid of the first.
//
// Nothing that the server sends is trusted. A failed check is an Error that names the step and, if
// it concerns one, the tile; the assembler then returns this error for every further message.
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

// Decoded tiles by content digest, for reuse in later steps and streams.
using CachedTiles = std::map<ContentDigest, std::shared_ptr<const LatticeMesh>>;

// A step that passed all checks.
struct CommittedStep {
  StepBegin begin;
  StepEnd end;
  LatticeMesh mesh;  // All tiles, welded.
  MeshTopology topology;
  std::vector<std::string> checks;  // Names of the checks the step passed.
  // The largest TileScalars::largest_deviation of the tiles; 0 without scalars.
  double largest_scalar_deviation = 0;
};
// Returns whether the step promises the topology of the full-resolution surface: sample shells of
// all samples always do.
[[nodiscard]] bool preserves_topology(const StepBegin& begin);
// Bounds the distance to the full-resolution surface, in world units, before vertices are
// rounded to the lattice. nullopt for previews, the paper's error measure, and where features may
// vanish.
[[nodiscard]] std::optional<double> distance_bound(const StepBegin& begin);
// Returns the same bound for the mesh as sent, including lattice_rounding_world().
[[nodiscard]] std::optional<double> mesh_distance_bound(const StepBegin& begin,
                                                        const DatasetInfo& info);
// Returns whether the step's mesh is the full-resolution surface with vertices on the lattice. Only
// then is its area exact: a distance bound does not bound the area.
[[nodiscard]] bool is_full_resolution(const StepBegin& begin);
using CommittedStepPtr = std::shared_ptr<const CommittedStep>;

// The server refused the request or ended the stream with an error; not a failed check.
struct Refusal {
  Error error;
};

// The effect of a message: nothing to show (or it belongs to another stream), a step, or the end.
using AssemblyEvent = std::variant<std::monostate, CommittedStepPtr, StreamEnd, Refusal>;

class Assembler {
 public:
  // Uses the tiles of `held` that `open` names; the server sends the others.
  Assembler(DatasetInfo info, OpenStream open, CachedTiles held = {}, AssemblerLimits limits = {});

  [[nodiscard]] Result<AssemblyEvent> receive(const ServerMessage& message);

  // Returns the step to show: the last committed one, or null before the first.
  [[nodiscard]] const CommittedStepPtr& shown() const { return shown_; }
  // Returns all decoded tiles, including those of an unfinished step. After a lost connection the
  // repeated request can name them as held.
  [[nodiscard]] const CachedTiles& held() const { return held_; }
  // Decodes the sample shells still waiting. Shells are decoded in batches, on all threads.
  [[nodiscard]] Result<void> decode_waiting();

 private:
  struct Invariants {
    std::uint32_t step = 0;  // The step that established these values.
    std::int64_t euler_characteristic = 0;
    std::int64_t components = 0;
  };

  using TilePtr = std::shared_ptr<const LatticeMesh>;

  // Require that StreamValidator has accepted the message.
  Result<AssemblyEvent> take(const StepBegin& begin);
  Result<AssemblyEvent> take(const Tile& tile);
  Result<AssemblyEvent> take(const TileScalars& scalars);
  Result<AssemblyEvent> take(const StepEnd& end);
  Result<AssemblyEvent> take(const StreamEnd& end) { return end; }
  Result<AssemblyEvent> take(const ErrorReply& reply) { return Refusal{reply.error}; }
  template <typename Other>
  Result<AssemblyEvent> take(const Other&) {
    return AssemblyEvent{};
  }

  // Welds the tiles of the pending step, with their scalars if it has any.
  [[nodiscard]] Result<LatticeMesh> welded_step() const;
  // Merges the sample shells of the pending step and computes the topology.
  [[nodiscard]] MergedTiles joined_step(const DataBorder& border) const;
  // Returns the largest deviation of the pending step's scalars.
  [[nodiscard]] double largest_deviation() const;
  [[nodiscard]] std::optional<std::string> topology_fault(const StepBegin& begin,
                                                          const MeshTopology& topology);

  // A checked sample shell that has not been decoded.
  struct WaitingTile {
    std::uint32_t index = 0;
    std::shared_ptr<const std::string> payload;
  };

  struct TileValues {
    std::vector<float> values;
    double largest_deviation = 0;
  };

  DatasetInfo info_;
  CachedTiles held_;
  StreamValidator validator_;
  // The tiles of the pending step; null until received and decoded.
  std::vector<TilePtr> tiles_;
  // The boxes in which this assembler has marched; nullopt for cached tiles.
  std::vector<std::optional<MarchedBox>> marched_;
  // Tiles of the pending step that are not decoded yet.
  std::vector<WaitingTile> waiting_;
  std::uint64_t waiting_triangles_ = 0;
  std::map<ContentDigest, TileValues> scalars_;  // Received in this stream.
  CommittedStepPtr shown_;
  // Set by the first step that preserves the topology.
  std::optional<Invariants> invariants_;
  std::optional<Error> failed_;
};

}  // namespace multitetra

#include "client/assembler.hpp"

#include <algorithm>
#include <set>

#include "client/manifest_checks.hpp"
#include "common/wire/scalar_codes.hpp"

namespace multitetra {

// The step that is being received. A tile that is not there yet is null.
struct Assembler::PendingStep {
  StepBegin begin;
  std::vector<std::shared_ptr<const LatticeMesh>> tiles;
  std::uint32_t tiles_received = 0;
  std::uint64_t bytes_received = 0;
};

namespace {

tl::unexpected<Error> fault(std::uint32_t step, const std::string& what) {
  return fail(ErrorCode::kDamagedData, "Step " + std::to_string(step) + ": " + what + ".");
}

// A message of a stream before this one may still be under way; of a later one there is none.
enum class Belongs { kHere, kToAnEarlierStream, kNowhere };

Belongs belongs(std::uint64_t request_id, std::uint64_t current) {
  if (request_id == current) return Belongs::kHere;
  return request_id < current ? Belongs::kToAnEarlierStream : Belongs::kNowhere;
}

bool is_as_promised(const LatticeMesh& mesh, const TileSummary& promised, int resolution) {
  return mesh.resolution == resolution && mesh.triangles.size() == promised.triangles &&
         mesh.vertices.size() == promised.vertices &&
         std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                     [&](const LatticePoint& p) { return promised.cube.contains(p, resolution); });
}

LatticeMesh welded(const std::vector<std::shared_ptr<const LatticeMesh>>& tiles, int resolution) {
  std::vector<const LatticeMesh*> meshes;
  meshes.reserve(tiles.size());
  for (const auto& tile : tiles) meshes.push_back(tile.get());
  return weld(meshes, resolution);
}

HeldTiles told_of(HeldTiles held, const std::vector<ContentDigest>& digests) {
  const std::set<ContentDigest> told(digests.begin(), digests.end());
  std::erase_if(held, [&told](const auto& tile) { return !told.contains(tile.first); });
  return held;
}

}  // namespace

bool preserves_topology(const StepBegin& begin) {
  return begin.request.topology_tolerance == 0 && begin.finest_spacing == 1;
}

Assembler::Assembler(DatasetInfo info, OpenStream open, HeldTiles held, AssemblerLimits limits)
    : info_(std::move(info)),
      open_(std::move(open)),
      limits_(limits),
      held_(told_of(std::move(held), open_.held)) {}

Result<Progress> Assembler::receive(const ServerMessage& message) {
  if (failed_) return tl::unexpected(*failed_);
  auto progress = std::visit([this](const auto& m) { return take(m); }, message);
  if (!progress) {
    failed_ = progress.error();
    pending_.reset();
  }
  return progress;
}

// Of the connection, or of requests that this assembler does not follow.
template <typename Other>
Result<Progress> Assembler::take(const Other&) {
  return Progress{};
}

Result<Progress> Assembler::take(const ErrorReply& reply) {
  if (reply.request_id != open_.request_id && reply.request_id != 0) return Progress{};
  pending_.reset();
  has_ended_ = true;
  return Refusal{reply.error};
}

Result<Progress> Assembler::take(const StepBegin& begin) {
  switch (belongs(begin.request_id, open_.request_id)) {
    case Belongs::kToAnEarlierStream:
      return Progress{};
    case Belongs::kNowhere:
      return fault(begin.step, "it belongs to a request that was never made");
    case Belongs::kHere:
      break;
  }
  if (has_ended_) return fault(begin.step, "it begins after the end of its stream");
  if (pending_) return fault(begin.step, "it begins before the step before has ended");
  if (begin.step != steps_committed_) {
    return fault(begin.step, "step " + std::to_string(steps_committed_) + " was due");
  }
  if (shown_ && shown_->begin.is_final) return fault(begin.step, "it follows the final step");
  if (begin.step >= limits_.steps) {
    return fault(begin.step, "this client allows " + std::to_string(limits_.steps) + " steps");
  }
  if (const auto found = manifest_fault(begin, open_, info_, limits_)) {
    return fault(begin.step, *found);
  }
  auto pending = std::make_shared<PendingStep>();
  pending->begin = begin;
  for (std::size_t i = 0; i < begin.tiles.size(); ++i) {
    const auto held = held_.find(begin.tiles[i].digest);
    if (held == held_.end()) announced_.add(begin.tiles[i]);
    pending->tiles.push_back(held == held_.end() ? nullptr : held->second);
    if (held != held_.end() &&
        !is_as_promised(*held->second, begin.tiles[i], begin.request.lattice_resolution)) {
      return fault(begin.step, tile_name(begin, i) +
                                   " is held already, but with other counts or "
                                   "outside its cube");
    }
  }
  if (const auto beyond = excess(announced_, limits_)) {
    return fault(begin.step, "with the steps before " + *beyond);
  }
  pending_ = std::move(pending);
  return Progress{};
}

Result<Progress> Assembler::take(const Tile& tile) {
  switch (belongs(tile.request_id, open_.request_id)) {
    case Belongs::kToAnEarlierStream:
      return Progress{};
    case Belongs::kNowhere:
      return fault(tile.step, "a tile belongs to a request that was never made");
    case Belongs::kHere:
      break;
  }
  if (!pending_ || tile.step != pending_->begin.step) {
    return fault(tile.step, "a tile comes outside of its step");
  }
  const StepBegin& begin = pending_->begin;
  if (tile.index >= begin.tiles.size()) {
    return fault(tile.step, "tile " + std::to_string(tile.index) + " comes, but there are only " +
                                std::to_string(begin.tiles.size()));
  }
  const std::string name = tile_name(begin, tile.index);
  if (pending_->tiles[tile.index]) return fault(tile.step, name + " comes, but is there already");
  const TileSummary& promised = begin.tiles[tile.index];
  if (!tile.payload || tile.payload->size() != promised.bytes) {
    return fault(tile.step, name + " has " +
                                std::to_string(tile.payload ? tile.payload->size() : 0) +
                                " bytes; promised were " + std::to_string(promised.bytes));
  }
  auto mesh = decode_tile(*tile.payload, promised, begin.request.lattice_resolution,
                          begin.request.normal_bits);
  if (!mesh) return fault(tile.step, name + " is damaged: " + mesh.error().text);
  const auto decoded = std::make_shared<const LatticeMesh>(*std::move(mesh));
  pending_->tiles[tile.index] = decoded;
  held_.emplace(promised.digest, decoded);
  ++pending_->tiles_received;
  pending_->bytes_received += tile.payload->size();
  return Progress{};
}

Result<Progress> Assembler::take(const TileScalars& scalars) {
  switch (belongs(scalars.request_id, open_.request_id)) {
    case Belongs::kToAnEarlierStream:
      return Progress{};
    case Belongs::kNowhere:
      return fault(scalars.step, "scalars belong to a request that was never made");
    case Belongs::kHere:
      break;
  }
  if (!pending_ || scalars.step != pending_->begin.step) {
    return fault(scalars.step, "scalars come outside of their step");
  }
  const StepBegin& begin = pending_->begin;
  if (!begin.scalars) return fault(scalars.step, "scalars come that nobody asked for");
  if (scalars.index >= begin.tiles.size() || !pending_->tiles[scalars.index]) {
    return fault(scalars.step,
                 "scalars come for tile " + std::to_string(scalars.index) + ", which is not there");
  }
  const std::string name = tile_name(begin, scalars.index);
  auto values =
      decode_scalars(*scalars.codes, pending_->tiles[scalars.index]->vertices, *begin.scalars);
  if (!values) return fault(scalars.step, name + ": " + values.error().text);
  const bool is_new = scalars_
                          .try_emplace(begin.tiles[scalars.index].digest,
                                       TileValues{*std::move(values), scalars.largest_deviation})
                          .second;
  if (!is_new) return fault(scalars.step, "scalars of " + name + " come twice");
  return Progress{};
}

Result<LatticeMesh> Assembler::welded_step() const {
  const StepBegin& begin = pending_->begin;
  const int resolution = begin.request.lattice_resolution;
  if (!begin.scalars) return welded(pending_->tiles, resolution);
  std::vector<std::shared_ptr<const LatticeMesh>> tiles;
  for (std::size_t i = 0; i < pending_->tiles.size(); ++i) {
    const auto values = scalars_.find(begin.tiles[i].digest);
    if (values == scalars_.end()) {
      return fault(begin.step, "it ends without the scalars of " + tile_name(begin, i));
    }
    auto tile = std::make_shared<LatticeMesh>(*pending_->tiles[i]);
    tile->scalars = values->second.values;
    tiles.push_back(std::move(tile));
  }
  return welded(tiles, resolution);
}

double Assembler::largest_deviation() const {
  double largest = 0;
  for (const TileSummary& tile : pending_->begin.tiles) {
    const auto values = scalars_.find(tile.digest);
    if (values != scalars_.end()) largest = std::max(largest, values->second.largest_deviation);
  }
  return largest;
}

Result<Progress> Assembler::take(const StepEnd& end) {
  switch (belongs(end.request_id, open_.request_id)) {
    case Belongs::kToAnEarlierStream:
      return Progress{};
    case Belongs::kNowhere:
      return fault(end.step, "its end belongs to a request that was never made");
    case Belongs::kHere:
      break;
  }
  if (!pending_ || end.step != pending_->begin.step) {
    return fault(end.step, "it ends, but has not begun");
  }
  const StepBegin& begin = pending_->begin;
  const auto missing = std::find(pending_->tiles.begin(), pending_->tiles.end(), nullptr);
  if (missing != pending_->tiles.end()) {
    const auto index = static_cast<std::size_t>(missing - pending_->tiles.begin());
    return fault(end.step, "it ends without " + tile_name(begin, index));
  }
  if (end.tiles_sent != pending_->tiles_received || end.payload_bytes != pending_->bytes_received) {
    return fault(end.step, "the server counts " + std::to_string(end.tiles_sent) + " tiles and " +
                               std::to_string(end.payload_bytes) + " bytes; " +
                               std::to_string(pending_->tiles_received) + " and " +
                               std::to_string(pending_->bytes_received) + " came");
  }
  auto step = std::make_shared<CommittedStep>();
  step->begin = begin;
  step->end = end;
  auto mesh = welded_step();
  if (!mesh) return tl::unexpected(mesh.error());
  step->mesh = *std::move(mesh);
  step->largest_scalar_deviation = largest_deviation();
  const ContentDigest found = digest(step->mesh);
  if (found != end.digest) {
    return fault(end.step,
                 "its digest is " + found.hex() + "; the server says " + end.digest.hex());
  }
  step->topology =
      topology(step->mesh, data_border(info_, begin.request.lattice_resolution,
                                       begin.request.topology_tolerance, begin.finest_spacing));
  if (const auto torn = topology_fault(begin, step->topology)) return fault(end.step, *torn);
  step->checks = {"tiles_complete", "tile_digests", "inside_cubes", "step_digest", "sound_mesh"};
  if (preserves_topology(begin)) step->checks.emplace_back("topology_preserved");
  pending_.reset();
  ++steps_committed_;
  shown_ = step;
  return shown_;
}

std::optional<std::string> Assembler::topology_fault(const StepBegin& begin,
                                                     const MeshTopology& found) {
  if (!found.is_sound()) {
    return "the mesh is torn: " + std::to_string(found.open_edges) + " open edges, " +
           std::to_string(found.nonmanifold_edges) + " non-manifold edges, " +
           std::to_string(found.degenerate_triangles) + " degenerate triangles";
  }
  if (!preserves_topology(begin)) return std::nullopt;
  if (!invariants_) {
    invariants_ = {begin.step, found.euler_characteristic, found.components};
    return std::nullopt;
  }
  if (found.euler_characteristic == invariants_->euler_characteristic &&
      found.components == invariants_->components) {
    return std::nullopt;
  }
  return "its topology differs from step " + std::to_string(invariants_->step) +
         ", though both preserve it: Euler characteristic " +
         std::to_string(found.euler_characteristic) + " instead of " +
         std::to_string(invariants_->euler_characteristic) + ", " +
         std::to_string(found.components) + " components instead of " +
         std::to_string(invariants_->components);
}

Result<Progress> Assembler::take(const StreamEnd& end) {
  if (belongs(end.request_id, open_.request_id) == Belongs::kToAnEarlierStream) return Progress{};
  const auto reject = [](const std::string& what) {
    return fail(ErrorCode::kDamagedData, "The stream's end: " + what + ".");
  };
  if (end.request_id != open_.request_id) return reject("it belongs to a request never made");
  if (has_ended_) return reject("it comes twice");
  if (end.steps != steps_committed_) {
    return reject("the server counts " + std::to_string(end.steps) + " steps; " +
                  std::to_string(steps_committed_) + " came");
  }
  const bool is_enough =
      shown_ && (shown_->begin.is_final || open_.steps == StepPolicy::kPreviewsOnly);
  const bool is_complete = !pending_ && is_enough;
  if (end.outcome == StreamOutcome::kComplete && !is_complete) {
    return reject("it says complete, but the final step is missing");
  }
  pending_.reset();
  has_ended_ = true;
  return end;
}

}  // namespace multitetra

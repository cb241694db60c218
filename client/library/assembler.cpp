#include "client/library/assembler.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "client/library/detail/manifest_checks.hpp"
#include "common/base/in_parallel.hpp"
#include "common/wire/scalar_codes.hpp"
#include "common/wire/shell_tile.hpp"

namespace multitetra {

namespace {

// Enough triangles to occupy all threads; a larger batch would delay decoding.
constexpr std::uint64_t kTrianglesDecodedAtOnce = 400'000;

ShellTileForm shell_form(const StepBegin& begin) {
  return {.lattice_resolution = begin.request.lattice_resolution,
          .finest_spacing = begin.finest_spacing,
          .shell = *begin.shell};
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

std::set<ContentDigest> digests_of(const CachedTiles& held) {
  std::set<ContentDigest> digests;
  for (const auto& [digest, tile] : held) digests.insert(digests.end(), digest);
  return digests;
}

// Keeps only the tiles that the request names: the server sends all others.
CachedTiles named_in(CachedTiles held, const std::vector<ContentDigest>& digests) {
  const std::set<ContentDigest> named(digests.begin(), digests.end());
  std::erase_if(held, [&named](const auto& tile) { return !named.contains(tile.first); });
  return held;
}

}  // namespace

bool preserves_topology(const StepBegin& begin) {
  return (begin.request.topology_tolerance == 0 || begin.shell) && begin.finest_spacing == 1;
}

std::optional<double> distance_bound(const StepBegin& begin) {
  const bool is_bounded = preserves_topology(begin) &&
                          (begin.request.error_measure == ErrorMeasure::kCertified || begin.shell);
  if (!is_bounded) return std::nullopt;
  return begin.error_bound_world;
}

std::optional<double> mesh_distance_bound(const StepBegin& begin, const DatasetInfo& info) {
  const auto distance = distance_bound(begin);
  if (!distance) return std::nullopt;
  return *distance + lattice_rounding_world(info, begin.request.lattice_resolution);
}

bool is_full_resolution(const StepBegin& begin) { return distance_bound(begin) == 0.0; }

Assembler::Assembler(DatasetInfo info, OpenStream open, CachedTiles held, AssemblerLimits limits)
    : info_(std::move(info)),
      held_(named_in(std::move(held), open.cached_tile_digests)),
      validator_(info_, std::move(open), digests_of(held_), limits) {}

Result<AssemblyEvent> Assembler::receive(const ServerMessage& message) {
  if (failed_) return tl::unexpected(*failed_);
  const auto accepted = validator_.accept(message);
  if (accepted && !*accepted) return AssemblyEvent{};
  auto progress = accepted ? std::visit([this](const auto& m) { return take(m); }, message)
                           : Result<AssemblyEvent>(tl::unexpected(accepted.error()));
  if (!progress) {
    failed_ = progress.error();
    tiles_.clear();
    marched_.clear();
    waiting_.clear();
  }
  return progress;
}

Result<AssemblyEvent> Assembler::take(const StepBegin& begin) {
  if (validator_.is_of_several()) {
    held_.clear();
    invariants_.reset();
  }
  tiles_.clear();
  marched_.assign(begin.tiles.size(), std::nullopt);
  waiting_.clear();
  waiting_triangles_ = 0;
  for (std::size_t i = 0; i < begin.tiles.size(); ++i) {
    const auto held = held_.find(begin.tiles[i].digest);
    tiles_.push_back(held == held_.end() ? nullptr : held->second);
    if (held != held_.end() &&
        !is_as_promised(*held->second, begin.tiles[i], begin.request.lattice_resolution)) {
      return step_fault(
          begin.step,
          tile_name(begin, i) + " is already held, but with different counts or outside its cube");
    }
  }
  return AssemblyEvent{};
}

Result<AssemblyEvent> Assembler::take(const Tile& tile) {
  const StepBegin& begin = validator_.step();
  const TileSummary& promised = begin.tiles[tile.index];
  if (begin.shell) {
    const auto checked = check_shell_tile(*tile.payload, promised, shell_form(begin));
    if (!checked) {
      return step_fault(tile.step,
                        tile_name(begin, tile.index) + " is damaged: " + checked.error().text);
    }
    waiting_.push_back({.index = tile.index, .payload = tile.payload});
    waiting_triangles_ += promised.triangles;
    if (waiting_triangles_ < kTrianglesDecodedAtOnce) return AssemblyEvent{};
    if (const auto decoded = decode_waiting(); !decoded) return tl::unexpected(decoded.error());
    return AssemblyEvent{};
  }
  auto mesh = decode_tile(*tile.payload, promised, begin.request.lattice_resolution,
                          begin.request.normal_bits);
  if (!mesh) {
    return step_fault(tile.step,
                      tile_name(begin, tile.index) + " is damaged: " + mesh.error().text);
  }
  tiles_[tile.index] = std::make_shared<const LatticeMesh>(*std::move(mesh));
  held_.emplace(promised.digest, tiles_[tile.index]);
  return AssemblyEvent{};
}

Result<void> Assembler::decode_waiting() {
  const std::vector<WaitingTile> waiting = std::exchange(waiting_, {});
  waiting_triangles_ = 0;
  if (waiting.empty()) return {};
  const StepBegin& begin = validator_.step();
  const ShellTileForm form = shell_form(begin);
  std::vector<Result<LatticeMesh>> decoded(waiting.size());
  in_parallel(waiting.size(), [&](std::size_t i) {
    decoded[i] = decode_shell_tile(*waiting[i].payload, begin.tiles[waiting[i].index], form);
  });
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    const std::uint32_t index = waiting[i].index;
    if (!decoded[i]) {
      return step_fault(begin.step,
                        tile_name(begin, index) + " is damaged: " + decoded[i].error().text);
    }
    tiles_[index] = std::make_shared<const LatticeMesh>(*std::move(decoded[i]));
    marched_[index] = marched_box(*waiting[i].payload);
    held_.emplace(begin.tiles[index].digest, tiles_[index]);
  }
  return {};
}

Result<AssemblyEvent> Assembler::take(const TileScalars& scalars) {
  const StepBegin& begin = validator_.step();
  const std::string name = tile_name(begin, scalars.index);
  auto values = decode_scalars(*scalars.codes, tiles_[scalars.index]->vertices, *begin.scalars);
  if (!values) return step_fault(scalars.step, name + ": " + values.error().text);
  const bool is_new = scalars_
                          .try_emplace(begin.tiles[scalars.index].digest,
                                       TileValues{*std::move(values), scalars.largest_deviation})
                          .second;
  if (!is_new) return step_fault(scalars.step, "scalars of " + name + " were sent twice");
  return AssemblyEvent{};
}

Result<LatticeMesh> Assembler::welded_step() const {
  const StepBegin& begin = validator_.step();
  const int resolution = begin.request.lattice_resolution;
  if (!begin.scalars) return welded(tiles_, resolution);
  std::vector<TilePtr> tiles;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const auto values = scalars_.find(begin.tiles[i].digest);
    if (values == scalars_.end()) {
      return step_fault(begin.step, "it ends without the scalars of " + tile_name(begin, i));
    }
    auto tile = std::make_shared<LatticeMesh>(*tiles_[i]);
    tile->scalars = values->second.values;
    tiles.push_back(std::move(tile));
  }
  return welded(tiles, resolution);
}

MergedTiles Assembler::joined_step(const DataBorder& border) const {
  const StepBegin& begin = validator_.step();
  std::vector<TileInCube> tiles;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    tiles.push_back({.mesh = tiles_[i].get(), .cube = begin.tiles[i].cube, .marched = marched_[i]});
  }
  const ForEachTile for_each = [](std::size_t count, const std::function<void(std::size_t)>& body) {
    in_parallel(count, body);
  };
  return merged_tiles(tiles, begin.request.lattice_resolution, border, for_each);
}

double Assembler::largest_deviation() const {
  double largest = 0;
  for (const TileSummary& tile : validator_.step().tiles) {
    const auto values = scalars_.find(tile.digest);
    if (values != scalars_.end()) largest = std::max(largest, values->second.largest_deviation);
  }
  return largest;
}

Result<AssemblyEvent> Assembler::take(const StepEnd& end) {
  const StepBegin& begin = validator_.step();
  if (const auto decoded = decode_waiting(); !decoded) return tl::unexpected(decoded.error());
  auto step = std::make_shared<CommittedStep>();
  step->begin = begin;
  step->end = end;
  const DataBorder border = data_border(info_, begin.request.lattice_resolution,
                                        begin.request.topology_tolerance, begin.finest_spacing);
  if (begin.shell) {
    MergedTiles joined = joined_step(border);
    step->mesh = std::move(joined.mesh);
    step->topology = joined.topology;
  } else {
    auto mesh = welded_step();
    if (!mesh) return tl::unexpected(mesh.error());
    step->mesh = *std::move(mesh);
    step->topology = topology(step->mesh, border);
  }
  step->largest_scalar_deviation = largest_deviation();
  // StreamValidator has already checked the digests of shell payloads against the step's digest.
  // Other tiles were checked as they were decoded, and the digest of a mesh is their sum.
  ContentDigest found;
  for (const TileSummary& tile : begin.tiles) found += tile.digest;
  if (begin.shell) found = end.digest;
  if (found != end.digest) {
    return step_fault(end.step,
                      "its digest is " + found.hex() + "; the server sent " + end.digest.hex());
  }
  if (const auto torn = topology_fault(begin, step->topology)) return step_fault(end.step, *torn);
  step->checks = {"tiles_complete", "tile_digests", "inside_cubes", "step_digest", "sound_mesh"};
  if (preserves_topology(begin)) step->checks.emplace_back("topology_preserved");
  tiles_.clear();
  shown_ = step;
  return shown_;
}

std::optional<std::string> Assembler::topology_fault(const StepBegin& begin,
                                                     const MeshTopology& found) {
  if (!found.is_sound()) {
    return "the mesh has defects: " + std::to_string(found.open_edges) + " open edges, " +
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

}  // namespace multitetra

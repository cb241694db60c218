#include "server/extraction/detail/simplified_surface.hpp"

#include <ctime>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/base/parallel_tree.hpp"
#include "common/mesh/triangle_tree.hpp"

namespace multitetra {
namespace {

// For each cube, the surface that lies in it but in none of its children; nullopt: none.
using CubesOfLevel = std::map<OctreeCube, std::optional<SimplifiedPiece>>;

// Returns, by exponent, the cubes of the tiles and all their ancestors.
std::vector<CubesOfLevel> cubes_around(std::vector<SimplifiedTile> tiles, int root_exponent) {
  std::vector<CubesOfLevel> cubes(static_cast<std::size_t>(root_exponent) + 1);
  const auto cubes_like = [&](const OctreeCube& cube) -> CubesOfLevel& {
    return cubes[static_cast<std::size_t>(cube.exponent)];
  };
  for (SimplifiedTile& tile : tiles) {
    cubes_like(tile.cube)[tile.cube] = std::move(tile.piece);
    for (OctreeCube cube = tile.cube; cube.exponent < root_exponent;) {
      cube = cube.parent();
      if (!cubes_like(cube).try_emplace(cube).second) break;
    }
  }
  return cubes;
}

// For each cube, the triangles that lie in no single cube of its size and extend into it. Its own
// surface and those in other cubes need no check, as they stay inside their cubes.
using ObstaclesOfLevel = std::map<OctreeCube, std::vector<LatticeTriangle>>;

bool reaches_into(const LatticeTriangle& triangle, const OctreeCube& cube, int resolution) {
  const TriangleBox box = box_of(triangle);
  const auto overlaps = [&](std::int32_t low, std::int32_t high, std::int32_t position) {
    const std::int64_t begin = std::int64_t{position} << (cube.exponent + resolution);
    return high > begin && low < begin + (std::int64_t{1} << (cube.exponent + resolution));
  };
  return overlaps(box.low.x, box.high.x, cube.x) && overlaps(box.low.y, box.high.y, cube.y) &&
         overlaps(box.low.z, box.high.z, cube.z);
}

// Returns the obstacles by exponent.
std::vector<ObstaclesOfLevel> obstacles_in(const std::vector<CubesOfLevel>& cubes, int resolution) {
  std::vector<ObstaclesOfLevel> obstacles(cubes.size());
  for (std::size_t size = cubes.size() - 1; size-- > 0;) {
    for (const auto& entry : cubes[size]) {
      const auto& cube = entry.first;
      std::vector<LatticeTriangle>& found = obstacles[size][cube];
      const auto look_at = [&](const LatticeTriangle& triangle) {
        if (reaches_into(triangle, cube, resolution)) found.push_back(triangle);
      };
      if (const auto& above = cubes[size + 1].at(cube.parent())) {
        std::vector<LatticeTriangle> triangles;
        above->append_triangles(triangles);
        for (const LatticeTriangle& triangle : triangles) look_at(triangle);
      }
      for (const LatticeTriangle& triangle : obstacles[size + 1][cube.parent()]) look_at(triangle);
    }
  }
  return obstacles;
}

double seconds_of_this_thread() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// A cube with the surface in none of its children; later with the simplified surface of all of it.
struct CubeInTree {
  OctreeCube cube;
  std::optional<SimplifiedPiece> own;
  std::vector<std::size_t> children;  // In the order of their cubes.
  std::size_t triangles = 0;          // Triangles in the cube.
  SimplifiedCube surface;
  SimplificationWork work;
};

// Returns the cubes with children before their parents; the last one is the root.
std::vector<CubeInTree> tree_of(std::vector<CubesOfLevel> cubes) {
  std::vector<CubeInTree> tree;
  std::map<OctreeCube, std::size_t> halves;
  for (CubesOfLevel& of_level : cubes) {
    std::map<OctreeCube, std::size_t> wholes;
    for (auto& [cube, own] : of_level) {
      wholes[cube] = tree.size();
      const std::size_t triangles = own ? own->triangles() : 0;
      tree.push_back({cube, std::move(own), {}, triangles, {}, {}});
    }
    for (const auto& [half, index] : halves) {
      CubeInTree& whole = tree[wholes.at(half.parent())];
      whole.children.push_back(index);
      whole.triangles += tree[index].triangles;
    }
    halves = std::move(wholes);
  }
  return tree;
}

// Returns a depth-first order: each cube after its children, those with most triangles first.
std::vector<std::size_t> depth_first(const std::vector<CubeInTree>& tree) {
  std::vector<std::size_t> order;
  std::vector<std::size_t> waiting = {tree.size() - 1};
  while (!waiting.empty()) {
    order.push_back(waiting.back());
    std::vector<std::size_t> children = tree[waiting.back()].children;
    waiting.pop_back();
    std::stable_sort(children.begin(), children.end(), [&tree](std::size_t a, std::size_t b) {
      return tree[a].triangles > tree[b].triangles;
    });
    waiting.insert(waiting.end(), children.begin(), children.end());
  }
  std::reverse(order.begin(), order.end());
  return order;
}

// Simplifies the surface in a cube whose children are complete.
void join(std::vector<CubeInTree>& tree, std::size_t index, const ObstaclesOfLevel& obstacles,
          const SimplificationOptions& options, const SimplifiedTileLimits& limits,
          const std::stop_token& stop) {
  CubeInTree& whole = tree[index];
  std::vector<SimplifiedCube> children;
  for (const std::size_t child : whole.children) {
    const SimplificationWork& before = tree[child].work;
    whole.work.seconds += before.seconds;
    whole.work.longest_chain = std::max(whole.work.longest_chain, before.longest_chain);
    children.push_back(std::move(tree[child].surface));
  }
  const double start = seconds_of_this_thread();
  const auto in_the_way = obstacles.find(whole.cube);
  whole.surface = join_simplified(
      whole.cube, std::move(children), std::move(whole.own), options, limits,
      [&stop] { throw_if_stopped(stop); },
      in_the_way == obstacles.end() ? Obstacles() : Obstacles(in_the_way->second));
  const double seconds = seconds_of_this_thread() - start;
  whole.work.seconds += seconds;
  whole.work.longest_chain += seconds;
}

// Simplifies the surface in all cubes, from the smallest up to the root.
CubeInTree joined(std::vector<CubesOfLevel> cubes, const std::vector<ObstaclesOfLevel>& obstacles,
                  const SimplificationOptions& options, const SimplifiedTileLimits& limits,
                  const std::stop_token& stop) {
  std::vector<CubeInTree> tree = tree_of(std::move(cubes));
  const std::vector<std::size_t> order = depth_first(tree);
  std::vector<std::size_t> ranks(tree.size());
  for (std::size_t place = 0; place < order.size(); ++place) ranks[order[place]] = place;
  std::vector<std::size_t> parents(tree.size());
  for (std::size_t index = 0; index < tree.size(); ++index) {
    for (const std::size_t child : tree[index].children) parents[ranks[child]] = ranks[index];
  }
  in_parallel_upwards(
      parents,
      [&](std::size_t place) {
        const auto size = static_cast<std::size_t>(tree[order[place]].cube.exponent);
        join(tree, order[place], obstacles[size], options, limits, stop);
      },
      stop);
  return std::move(tree.back());
}

// Returns the time of the last of the first `done` collapses.
double last_before(std::vector<double> times, std::size_t done) {
  if (done == 0) return -1;
  const auto last = times.begin() + static_cast<std::ptrdiff_t>(done - 1);
  std::nth_element(times.begin(), last, times.end());
  return *last;
}

}  // namespace

void SurfaceSimplifier::add(TileMesh tile, const SimplificationOptions& options,
                            const std::stop_token& stop) {
  SimplifiedPiece piece(std::move(tile.mesh), lattice_step_);
  if (!options.is_intersection_free) {
    piece.begin(options.max_distance, std::nullopt, [&stop] { throw_if_stopped(stop); });
  }
  const std::lock_guard lock(mutex_);
  tiles_.push_back({tile.cube, std::move(piece)});
}

SimplificationWork SurfaceSimplifier::simplify(const SimplificationOptions& options,
                                               const std::stop_token& stop,
                                               const SimplifiedTileLimits& limits) {
  // If nothing may change, leaves the pieces separate, so that a first stage can still start.
  if (tiles_.empty() || (options.is_resumable && options.max_distance.largest() == 0)) {
    std::ranges::sort(tiles_, {}, &SimplifiedTile::cube);  // They came in the order of threads.
    return {};
  }
  const int resolution = tiles_.front().piece.resolution();
  std::vector<CubesOfLevel> cubes = cubes_around(std::move(tiles_), root_exponent_);
  std::vector<ObstaclesOfLevel> obstacles(cubes.size());
  if (options.is_intersection_free) obstacles = obstacles_in(cubes, resolution);
  SimplifiedTileLimits here = limits;
  here.root_exponent = root_exponent_;
  CubeInTree root = joined(std::move(cubes), obstacles, options, here, stop);
  tiles_ = all_tiles(std::move(root.surface));
  return root.work;
}

std::size_t SurfaceSimplifier::triangles() const {
  std::size_t sum = 0;
  for (const SimplifiedTile& tile : tiles_) sum += tile.piece.triangles();
  return sum;
}

std::vector<TileMesh> SurfaceSimplifier::tiles(std::size_t max_triangles) const {
  const std::size_t least = triangles();
  std::vector<double> times;
  for (const SimplifiedTile& tile : tiles_) {
    for (const Collapse& collapse : tile.piece.history()) times.push_back(collapse.when);
  }
  // A collapse removes two triangles.
  const std::size_t undone =
      max_triangles > least ? std::min((max_triangles - least) / 2, times.size()) : 0;
  const double until = last_before(times, times.size() - undone);
  std::vector<TileMesh> tiles(tiles_.size());
  in_parallel(tiles.size(), [&](std::size_t i) {
    const SimplifiedPiece& piece = tiles_[i].piece;
    Simplified left = undone == 0 ? piece.result() : piece.result(until);
    tiles[i] = {
        .cube = tiles_[i].cube, .mesh = std::move(left.mesh), .simplification_bound = left.bound};
  });
  return tiles;
}

TiledMesh extract_simplified(const ResolvedStep& spec, int root_exponent,
                             const std::stop_token& stop,
                             const std::function<TiledMesh(const TakeTile&)>& extract) {
  if (!spec.request().simplify) return extract(nullptr);
  const SimplificationOptions options = spec.simplification();
  SurfaceSimplifier simplifier(options.lattice_step, root_exponent);
  TiledMesh surface =
      extract([&](TileMesh tile) { simplifier.add(std::move(tile), options, stop); });
  simplifier.simplify(options, stop);
  surface.tiles = simplifier.tiles();
  return surface;
}

}  // namespace multitetra

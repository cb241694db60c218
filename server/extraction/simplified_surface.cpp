#include "server/extraction/simplified_surface.hpp"

#include <ctime>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"

namespace multitetra {
namespace {

// What lies in a cube, and in none of its children.
using CubesOfOneSize = std::map<OctreeCube, std::optional<LatticeMesh>>;

// By exponent: the cubes of the tiles, and all cubes around them.
std::vector<CubesOfOneSize> cubes_around(std::vector<TileMesh> tiles, int root_exponent) {
  std::vector<CubesOfOneSize> cubes(static_cast<std::size_t>(root_exponent) + 1);
  const auto cubes_like = [&](const OctreeCube& cube) -> CubesOfOneSize& {
    return cubes[static_cast<std::size_t>(cube.exponent)];
  };
  for (TileMesh& tile : tiles) {
    cubes_like(tile.cube)[tile.cube] = std::move(tile.mesh);
    for (OctreeCube cube = tile.cube; cube.exponent < root_exponent;) {
      cube = cube.parent();
      if (!cubes_like(cube).try_emplace(cube).second) break;
    }
  }
  return cubes;
}

double seconds_of_this_thread() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// A cube, and what it took to simplify all that is in it.
struct JoinedCube {
  SimplifiedCube surface;
  SimplificationWork work;
};

// The surface in the cubes of one size, from that in the cubes half as large.
std::vector<JoinedCube> join_all(CubesOfOneSize cubes, std::vector<JoinedCube> halves,
                                 const SimplificationOfCubes& how,
                                 const SimplifiedTileLimits& limits, const std::stop_token& stop) {
  struct Joining {
    OctreeCube cube;
    std::optional<LatticeMesh> own;
    std::vector<SimplifiedCube> children;
    SimplificationWork before;
  };
  std::vector<Joining> joining;
  std::map<OctreeCube, std::size_t> index;
  for (auto& [cube, own] : cubes) {
    index[cube] = joining.size();
    joining.push_back({cube, std::move(own), {}, {}});
  }
  for (JoinedCube& half : halves) {
    Joining& whole = joining[index.at(half.surface.cube.parent())];
    whole.children.push_back(std::move(half.surface));
    whole.before.seconds += half.work.seconds;
    whole.before.longest_chain = std::max(whole.before.longest_chain, half.work.longest_chain);
  }
  std::vector<JoinedCube> joined(joining.size());
  in_parallel(
      joining.size(),
      [&](std::size_t i) {
        Joining& one = joining[i];
        const double start = seconds_of_this_thread();
        joined[i].surface =
            join_simplified(one.cube, std::move(one.children), std::move(one.own), how(one.cube),
                            limits, [&stop] { throw_if_stopped(stop); });
        const double seconds = seconds_of_this_thread() - start;
        joined[i].work = {.seconds = one.before.seconds + seconds,
                          .longest_chain = one.before.longest_chain + seconds};
      },
      stop);
  return joined;
}

}  // namespace

SimplificationWork simplify(TiledSurface& surface, int root_exponent,
                            const SimplificationOfCubes& how, const std::stop_token& stop,
                            const SimplifiedTileLimits& limits) {
  if (surface.tiles.empty()) return {};
  std::vector<JoinedCube> joined;
  for (CubesOfOneSize& cubes : cubes_around(std::move(surface.tiles), root_exponent)) {
    joined = join_all(std::move(cubes), std::move(joined), how, limits, stop);
  }
  surface.tiles = finished_tiles(std::move(joined.front().surface));
  return joined.front().work;
}

void simplify(TiledSurface& surface, const ResolvedStep& spec, int root_exponent,
              const std::stop_token& stop) {
  if (!spec.request().simplify) return;
  simplify(
      surface, root_exponent, [&](const OctreeCube& cube) { return spec.simplification(cube); },
      stop);
}

}  // namespace multitetra

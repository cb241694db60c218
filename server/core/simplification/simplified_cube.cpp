#include "server/core/simplification/simplified_cube.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace multitetra {
namespace {

void cut_off(SimplifiedCube& child, std::vector<SimplifiedTile>& tiles) {
  if (child.rest.triangles() > 0) tiles.push_back({child.cube, std::move(child.rest)});
}

// Joins the pieces of a cube and of its children.
class CubeJoin {
 public:
  CubeJoin(const SimplificationOptions& options, const SimplifiedTileLimits& limits,
           const std::function<void()>& checkpoint, Obstacles obstacles)
      : options_(options),
        limits_(limits),
        checkpoint_(checkpoint),
        others_(obstacles.begin(), obstacles.end()) {}

  SimplifiedCube joined(const OctreeCube& cube, std::vector<SimplifiedCube> children,
                        std::optional<SimplifiedPiece> own) {
    SimplifiedCube joined{.cube = cube, .tiles = {}, .rest = {}};
    for (const SimplifiedCube& child : children) {
      for (const SimplifiedTile& tile : child.tiles) add_obstacle(tile.piece);
    }
    const int stage = 2 * cube.exponent;
    const bool is_begun = own && own->is_new();
    if (own) {
      simplify_own(*own, children, stage);
      pieces_.push_back(*std::move(own));
    }
    for (SimplifiedCube& child : children) {
      std::move(child.tiles.begin(), child.tiles.end(), std::back_inserter(joined.tiles));
    }
    take_rests(std::move(children), joined.tiles);
    if (pieces_.empty()) return joined;
    const bool is_single = pieces_.size() == 1;
    joined.rest =
        is_single ? std::move(pieces_.front()) : SimplifiedPiece::joined(std::move(pieces_));
    // A single piece is already simplified, unless only its first stage has run.
    if (!is_single || is_begun) {
      const bool is_last = cube.exponent == limits_.root_exponent && !options_.is_resumable;
      joined.rest.simplify(options_.max_distance, checkpoint_, obstacles(), stage + 1, is_last);
    }
    return joined;
  }

 private:
  void add_obstacle(const SimplifiedPiece& piece) {
    if (options_.is_intersection_free) piece.append_triangles(others_);
  }
  [[nodiscard]] std::optional<Obstacles> obstacles() const {
    return options_.is_intersection_free ? std::optional(Obstacles(others_)) : std::nullopt;
  }

  // Runs the first stage of the cube's own piece, to which the children's rests are obstacles.
  void simplify_own(SimplifiedPiece& own, const std::vector<SimplifiedCube>& children, int stage) {
    const std::size_t without_rests = others_.size();
    for (const SimplifiedCube& child : children) add_obstacle(child.rest);
    const bool is_new = own.is_new();
    if (is_new) own.begin(options_.max_distance, obstacles(), checkpoint_);
    if (options_.is_resumable) own.record_history();
    if (!is_new) own.simplify(options_.max_distance, checkpoint_, obstacles(), stage);
    others_.resize(without_rests);
  }

  // Cuts the largest rests off as tiles until the pieces are within the limits with all others.
  void take_rests(std::vector<SimplifiedCube> children, std::vector<SimplifiedTile>& tiles) {
    std::size_t triangles = pieces_.empty() ? 0 : pieces_.front().triangles();
    std::size_t vertices_before = pieces_.empty() ? 0 : pieces_.front().vertices_before();
    for (const SimplifiedCube& child : children) {
      triangles += child.rest.triangles();
      vertices_before += child.rest.vertices_before();
    }
    std::stable_sort(children.begin(), children.end(), [](const auto& a, const auto& b) {
      return a.rest.triangles() > b.rest.triangles();
    });
    for (SimplifiedCube& child : children) {
      const bool is_too_much =
          triangles > limits_.triangles || vertices_before > limits_.vertices_before;
      if (is_too_much) {
        triangles -= child.rest.triangles();
        vertices_before -= child.rest.vertices_before();
        add_obstacle(child.rest);
        if (!options_.is_resumable) child.rest.finish();
        cut_off(child, tiles);
      } else if (child.rest.triangles() > 0) {
        pieces_.push_back(std::move(child.rest));
      }
    }
  }

  const SimplificationOptions& options_;
  const SimplifiedTileLimits& limits_;
  const std::function<void()>& checkpoint_;
  // With `is_intersection_free`: obstacles other than the pieces themselves.
  std::vector<LatticeTriangle> others_;
  std::vector<SimplifiedPiece> pieces_;
};

}  // namespace

SimplifiedCube join_simplified(const OctreeCube& cube, std::vector<SimplifiedCube> children,
                               std::optional<SimplifiedPiece> own,
                               const SimplificationOptions& options,
                               const SimplifiedTileLimits& limits,
                               const std::function<void()>& checkpoint, Obstacles obstacles) {
  return CubeJoin(options, limits, checkpoint, obstacles)
      .joined(cube, std::move(children), std::move(own));
}

std::vector<SimplifiedTile> all_tiles(SimplifiedCube root) {
  std::vector<SimplifiedTile> tiles = std::move(root.tiles);
  cut_off(root, tiles);
  std::sort(tiles.begin(), tiles.end(),
            [](const auto& a, const auto& b) { return a.cube < b.cube; });
  return tiles;
}

}  // namespace multitetra

#include "server/core/tiling.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "server/core/leaves.hpp"
#include "server/core/marching_tetrahedra.hpp"

namespace multitetra {
namespace {

// One after another: what was appended for one cube stays together in `out.rest`.
template <typename Sample>
class Collector {
 public:
  Collector(const Model& model, const Grid& grid, const SampledField<Sample>& field,
            const SurfaceOptions& options)
      : model_(model), grid_(grid), field_(field), options_(options) {}

  // Appends the surface of the cube to out_.rest and cuts tiles off where it grows too large.
  void collect(const OctreeCube& cube) {
    const std::size_t begin = out_.rest.size();
    std::array<std::size_t, 9>
        ends{};  // ends[i]: where the triangles of child i begin, ends[8]: where all end
    for (int i = 0; i < 8; ++i) {
      ends[static_cast<std::size_t>(i)] = out_.rest.size();
      if (is_refined(model_, grid_, cube.child(i))) collect(cube.child(i));
    }
    ends[8] = out_.rest.size();
    append_own(cube);
    cut_off(cube, begin, ends);
  }

  void join(const OctreeCube& cube, std::vector<CubeSurface> children) {
    std::array<std::size_t, 9> ends{};
    for (std::size_t i = 0; i < 8; ++i) {
      ends[i] = out_.rest.size();
      out_.tetrahedra += children[i].tetrahedra;
      out_.active_tetrahedra += children[i].active_tetrahedra;
      std::move(children[i].tiles.begin(), children[i].tiles.end(), std::back_inserter(out_.tiles));
      out_.rest.insert(out_.rest.end(), children[i].rest.begin(), children[i].rest.end());
    }
    ends[8] = out_.rest.size();
    append_own(cube);
    cut_off(cube, 0, ends);
  }

  [[nodiscard]] CubeSurface take() { return std::move(out_); }

 private:
  void append_own(const OctreeCube& cube) {
    visit_own_leaves(model_, cube, [this](const Tetrahedron& t) {
      ++out_.tetrahedra;
      const auto corners = t.corners();
      const std::array<float, 4> values = {field_.at(corners[0]), field_.at(corners[1]),
                                           field_.at(corners[2]), field_.at(corners[3])};
      const TetrahedronSurface surface =
          marching_tetrahedron(corners, values, options_.isovalue, options_.lattice_resolution);
      if (surface.count == 0) return;
      ++out_.active_tetrahedra;
      out_.rest.insert(out_.rest.end(), surface.triangles.begin(),
                       surface.triangles.begin() + static_cast<std::ptrdiff_t>(surface.count));
    });
  }

  // Makes tiles of the children with most triangles until the rest of the cube fits into one.
  void cut_off(const OctreeCube& cube, std::size_t begin, const std::array<std::size_t, 9>& ends) {
    std::size_t left = out_.rest.size() - begin;
    if (left <= options_.max_triangles) return;
    const auto size_of = [&](std::size_t child) { return ends[child + 1] - ends[child]; };
    std::array<std::size_t, 8> by_size = {0, 1, 2, 3, 4, 5, 6, 7};
    std::stable_sort(by_size.begin(), by_size.end(),
                     [&](std::size_t a, std::size_t b) { return size_of(a) > size_of(b); });
    std::array<bool, 8> is_cut{};
    for (const std::size_t child : by_size) {
      if (left <= options_.max_triangles || size_of(child) == 0) break;
      is_cut[child] = true;
      left -= size_of(child);
    }
    const auto at = [this](std::size_t i) {
      return out_.rest.begin() + static_cast<std::ptrdiff_t>(i);
    };
    auto keep = at(begin);
    for (std::size_t child = 0; child < 8; ++child) {
      if (is_cut[child]) {
        out_.tiles.push_back(
            {cube.child(static_cast<int>(child)), {at(ends[child]), at(ends[child + 1])}});
      } else {
        keep = std::move(at(ends[child]), at(ends[child + 1]), keep);
      }
    }
    keep = std::move(at(ends[8]), out_.rest.end(), keep);
    out_.rest.erase(keep, out_.rest.end());
  }

  const Model& model_;
  const Grid& grid_;
  const SampledField<Sample>& field_;
  const SurfaceOptions& options_;
  CubeSurface out_;
};

}  // namespace

CubeSurface surface_in_cube(const Model& model, const Field& field, const OctreeCube& cube,
                            const SurfaceOptions& options) {
  return field.visit([&](const auto& sampled) {
    Collector collector(model, field.grid(), sampled, options);
    collector.collect(cube);
    return collector.take();
  });
}

CubeSurface join_children(const Model& model, const Field& field, const OctreeCube& cube,
                          std::vector<CubeSurface> children, const SurfaceOptions& options) {
  return field.visit([&](const auto& sampled) {
    Collector collector(model, field.grid(), sampled, options);
    collector.join(cube, std::move(children));
    return collector.take();
  });
}

std::vector<CubeSurface::Piece> finished_tiles(CubeSurface root, const OctreeCube& root_cube) {
  std::vector<CubeSurface::Piece> tiles = std::move(root.tiles);
  if (!root.rest.empty()) tiles.push_back({root_cube, std::move(root.rest)});
  std::sort(tiles.begin(), tiles.end(),
            [](const auto& a, const auto& b) { return a.cube < b.cube; });
  return tiles;
}

}  // namespace multitetra

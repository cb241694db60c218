#include "server/core/tiling.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iterator>
#include <utility>

#include "server/core/leaves.hpp"
#include "server/core/marching_tetrahedra.hpp"
#include "server/core/octree_cube_surface.hpp"

namespace multitetra {
namespace {

// ---- where tetrahedra and values come from

// Any model over a field.
template <typename Sample>
class FieldSource {
 public:
  FieldSource(const Model& model, const Grid& grid, const SampledField<Sample>& field,
              const SurfaceOptions& options)
      : model_(model), grid_(grid), field_(field), options_(options) {}

  [[nodiscard]] bool is_refined(const OctreeCube& cube) const {
    return multitetra::is_refined(model_, grid_, cube);
  }
  void append_own(const OctreeCube& cube, CubeSurface& out) const {
    visit_own_leaves(model_, cube, [&](const Tetrahedron& t) {
      ++out.tetrahedra;
      const auto corners = t.corners();
      const std::array<float, 4> values = {field_.at(corners[0]), field_.at(corners[1]),
                                           field_.at(corners[2]), field_.at(corners[3])};
      const TetrahedronSurface surface =
          marching_tetrahedron(corners, values, options_.isovalue, options_.lattice_resolution);
      if (surface.count == 0) return;
      ++out.active_tetrahedra;
      out.rest.insert(out.rest.end(), surface.triangles.begin(),
                      surface.triangles.begin() + static_cast<std::ptrdiff_t>(surface.count));
    });
  }

 private:
  const Model& model_;
  const Grid& grid_;
  const SampledField<Sample>& field_;
  const SurfaceOptions& options_;
};

// A prepared volume.
class PreparedSource {
 public:
  PreparedSource(const PreparedModel& model, const SurfaceOptions& options, FineArrays& arrays)
      : model_(model),
        info_(model.volume().info),
        coarse_(coarse_extent(info_)),
        fine_(model.volume(), model.fine_options(), arrays),
        surface_(options.isovalue, options.lattice_resolution) {}

  // Makes everything inside the cube available.
  void load(const OctreeCube& cube) {
    fine_.load(cube, [this](const OctreeCube& cell) { return model_.is_wanted(cell); });
  }

  [[nodiscard]] bool is_refined(const OctreeCube& cube) const {
    if (cube.exponent < 1) return false;
    const DividingPoint point = centre(cube);
    if (cube.exponent > kSpectrumExponent) {
      return cube.exponent == info_.grid_exponent || model_.kept(point);
    }
    if (cube.exponent == kSpectrumExponent && !fine_.is_wanted(cube)) return false;
    return model_.kept(point.at(), point.spacing(), fine_.error(fine_.index(point.at())));
  }

  void append_own(const OctreeCube& cube, CubeSurface& out) {
    OctreeCubePoints points = points_of(cube);
    cube.exponent > kSpectrumExponent ? read_coarse(points) : read_fine(points);
    for (int i = 0; i < 8; ++i) {
      if (is_refined(cube.child(i))) points.kept |= 1U << corner_of_child(points, i);
    }
    const OctreeCubeSurface::Counts counts = surface_.append(points, out.rest);
    out.tetrahedra += counts.tetrahedra;
    out.active_tetrahedra += counts.active_tetrahedra;
  }

 private:
  // Bits of the six face centres and twelve edge midpoints.
  static constexpr std::uint32_t kFacesAndEdges = [] {
    std::uint32_t bits = 0;
    for (unsigned i = 0; i < 27; ++i) {
      const int middles = (i % 3 == 1) + (i / 3 % 3 == 1) + (i / 9 == 1);
      if (middles == 1 || middles == 2) bits |= 1U << i;
    }
    return bits;
  }();

  void read_coarse(OctreeCubePoints& points) const {
    for (std::size_t i = 0; i < 27; ++i) points.values[i] = coarse_value(points.at(i));
    for (std::uint32_t left = kFacesAndEdges; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      if (model_.kept(DividingPoint(points.at(i)))) points.kept |= 1U << i;
    }
  }
  void read_fine(OctreeCubePoints& points) const {
    const std::ptrdiff_t centre = fine_.index(points.centre);
    const std::array<std::ptrdiff_t, 3> stride = {points.step * points.turned[0],
                                                  points.step * points.turned[1] * fine_.row(),
                                                  points.step * points.turned[2] * fine_.slice()};
    std::array<std::ptrdiff_t, 27> at;
    std::size_t i = 0;
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x, ++i) {
          at[i] = centre + x * stride[0] + y * stride[1] + z * stride[2];
          points.values[i] = fine_.value(at[i]);
        }
      }
    }
    for (std::uint32_t left = kFacesAndEdges; left != 0; left &= left - 1) {
      const auto p = static_cast<std::size_t>(std::countr_zero(left));
      // Where a face or an edge lies, its spacing is that of the cube's centre.
      const bool kept = model_.kept(points.at(p), points.step, fine_.error(at[p]));
      points.kept |= static_cast<std::uint32_t>(kept) << p;
    }
  }
  // Requires coordinates that are multiples of kSpectrumSpacing.
  [[nodiscard]] float coarse_value(GridPoint p) const {
    const GridPoint at = coarse_.unit_point(p);
    if (!coarse_.contains(at)) return outside_value(info_);
    return visit_type(info_.type, [&]<typename Sample>(const Sample*) {
      Sample sample;
      std::memcpy(&sample, model_.volume().coarse.data() + sizeof(Sample) * coarse_.index(at),
                  sizeof(Sample));
      return static_cast<float>(sample);
    });
  }

  const PreparedModel& model_;
  const DatasetInfo& info_;
  LevelExtent coarse_;
  FineErrors fine_;
  OctreeCubeSurface surface_;
};

// ---- tiles

// One after another: what was appended for one cube stays together in `out.rest`.
template <typename Source>
class Collector {
 public:
  Collector(Source& source, const SurfaceOptions& options) : source_(source), options_(options) {}

  // Appends the surface of the cube to out_.rest and cuts tiles off where it grows too large.
  void collect(const OctreeCube& cube) {
    const std::size_t begin = out_.rest.size();
    std::array<std::size_t, 9>
        ends{};  // ends[i]: where the triangles of child i begin, ends[8]: where all end
    for (int i = 0; i < 8; ++i) {
      ends[static_cast<std::size_t>(i)] = out_.rest.size();
      if (source_.is_refined(cube.child(i))) collect(cube.child(i));
    }
    ends[8] = out_.rest.size();
    source_.append_own(cube, out_);
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
    source_.append_own(cube, out_);
    cut_off(cube, 0, ends);
  }

  [[nodiscard]] CubeSurface take() { return std::move(out_); }

 private:
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

  Source& source_;
  const SurfaceOptions& options_;
  CubeSurface out_;
};

}  // namespace

CubeSurface surface_in_cube(const Model& model, const Field& field, const OctreeCube& cube,
                            const SurfaceOptions& options) {
  return field.visit([&](const auto& sampled) {
    FieldSource source(model, field.grid(), sampled, options);
    Collector collector(source, options);
    collector.collect(cube);
    return collector.take();
  });
}

CubeSurface join_children(const Model& model, const Field& field, const OctreeCube& cube,
                          std::vector<CubeSurface> children, const SurfaceOptions& options) {
  return field.visit([&](const auto& sampled) {
    FieldSource source(model, field.grid(), sampled, options);
    Collector collector(source, options);
    collector.join(cube, std::move(children));
    return collector.take();
  });
}

CubeSurface surface_in_cube(const PreparedModel& model, const OctreeCube& cube,
                            const SurfaceOptions& options, FineArrays& arrays) {
  PreparedSource source(model, options, arrays);
  source.load(cube);
  Collector collector(source, options);
  collector.collect(cube);
  return collector.take();
}

CubeSurface join_children(const PreparedModel& model, const OctreeCube& cube,
                          std::vector<CubeSurface> children, const SurfaceOptions& options) {
  FineArrays none;  // Nothing finer than the spectrum lies between the children.
  PreparedSource source(model, options, none);
  Collector collector(source, options);
  collector.join(cube, std::move(children));
  return collector.take();
}

bool is_refined(const PreparedModel& model, const OctreeCube& cube) {
  return cube.exponent == model.volume().info.grid_exponent || model.kept(centre(cube));
}

std::vector<CubeSurface::Piece> finished_tiles(CubeSurface root, const OctreeCube& root_cube) {
  std::vector<CubeSurface::Piece> tiles = std::move(root.tiles);
  if (!root.rest.empty()) tiles.push_back({root_cube, std::move(root.rest)});
  std::sort(tiles.begin(), tiles.end(),
            [](const auto& a, const auto& b) { return a.cube < b.cube; });
  return tiles;
}

}  // namespace multitetra

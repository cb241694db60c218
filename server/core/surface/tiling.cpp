#include "server/core/surface/tiling.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "common/mesh/vertex_numbers.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/surface/detail/octree_cube_surface.hpp"
#include "server/core/surface/marching_tetrahedra.hpp"

namespace multitetra {
namespace {

// ---- sources of tetrahedra and values

// Returns a bit for each refined child, with one query per child.
template <typename Source>
unsigned refined_children_of(const Source& source, const OctreeCube& cube) {
  unsigned refined = 0;
  if (cube.exponent <= 1) return refined;
  for (int i = 0; i < 8; ++i) {
    refined |= static_cast<unsigned>(source.is_refined(cube.child(i))) << i;
  }
  return refined;
}

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
  // Returns a bit for each refined child.
  [[nodiscard]] unsigned refined_children(const OctreeCube& cube) const {
    return refined_children_of(*this, cube);
  }
  // Appends the surface in the cube's own tetrahedra. All triangles of `mesh` must come from this
  // source. `refined` is refined_children(cube).
  OctreeCubeSurface::Counts append_own(const OctreeCube& cube, unsigned /*refined*/,
                                       LatticeMesh& mesh) {
    OctreeCubeSurface::Counts counts;
    visit_own_leaves(model_, cube, [&](const Tetrahedron& t) {
      ++counts.tetrahedra;
      const auto corners = t.corners();
      const std::array<float, 4> values = {field_.at(corners[0]), field_.at(corners[1]),
                                           field_.at(corners[2]), field_.at(corners[3])};
      const TetrahedronSurface surface =
          marching_tetrahedron(corners, values, options_.isovalue, options_.lattice_resolution);
      if (surface.count == 0) return;
      ++counts.active_tetrahedra;
      for (std::size_t i = 0; i < surface.count; ++i) {
        const auto& [p, q, r] = surface.triangles[i];
        mesh.triangles.push_back({numbers_.number(p, mesh.vertices),
                                  numbers_.number(q, mesh.vertices),
                                  numbers_.number(r, mesh.vertices)});
      }
    });
    return counts;
  }

 private:
  const Model& model_;
  const Grid& grid_;
  const SampledField<Sample>& field_;
  const SurfaceOptions& options_;
  VertexNumbers numbers_;
};

// A model of a prepared volume.
class PreparedSource {
 public:
  PreparedSource(const PreparedModel& model, const SurfaceOptions& options, CubeMemory& memory)
      : model_(model),
        info_(model.volume().info),
        coarse_(coarse_extent(info_)),
        coarse_samples_(model_.volume().coarse.bytes()),
        fine_(model.volume(), model.fine_options(), memory.fine),
        surface_(options.isovalue, options.lattice_resolution),
        vertices_(memory.vertices) {}

  // Loads the whole interior of the cube.
  void load(const OctreeCube& cube) {
    vertices_.begin(cube, 0);
    fine_.load(cube, [this](const OctreeCube& cell) { return model_.is_wanted(cell); });
  }
  // Prepares only the cube's own tetrahedra. Requires a cube larger than a cell.
  void load_own(const OctreeCube& cube) { vertices_.begin(cube, cube.exponent - 1); }

  [[nodiscard]] bool is_refined(const OctreeCube& cube) const {
    if (cube.exponent < 1) return false;
    const DividingPoint point = center(cube);
    if (cube.exponent > kSpectrumExponent) {
      return cube.exponent == info_.grid_exponent || model_.kept(point);
    }
    if (cube.exponent == kSpectrumExponent && !fine_.is_wanted(cube)) return false;
    return model_.kept(point.at(), point.spacing(), fine_.error(point.at()));
  }

  [[nodiscard]] unsigned refined_children(const OctreeCube& cube) const {
    if (cube.exponent > kSpectrumExponent || cube.exponent <= 1 || !model_.has_one_threshold()) {
      return refined_children_of(*this, cube);
    }
    // The children's centers are the corners of a cube of half the size with the same center.
    const OctreeCubePoints points = points_of(cube);
    const std::int32_t step = points.step / 2;
    if (!model_.may_keep(step)) return 0;
    const std::uint32_t exceeding = fine_.exceeding_neighbours(points.center, step, {1, 1, 1});
    unsigned refined = 0;
    for (unsigned i = 0; i < 8; ++i) {
      const unsigned corner = (i & 1) * 2 + (i >> 1 & 1) * 6 + (i >> 2) * 18;
      refined |= (exceeding >> corner & 1U) << i;
    }
    return refined;
  }

  OctreeCubeSurface::Counts append_own(const OctreeCube& cube, unsigned refined,
                                       LatticeMesh& mesh) {
    OctreeCubePoints points = points_of(cube);
    cube.exponent > kSpectrumExponent ? read_coarse(points) : read_fine(points);
    for (; refined != 0; refined &= refined - 1) {
      points.kept |= 1U << corner_of_child(points, std::countr_zero(refined));
    }
    return surface_.append(points, vertices_, mesh);
  }

 private:
  // Bits of the six face centers and twelve edge midpoints.
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
    for (std::uint32_t bits = kFacesAndEdges; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(bits));
      if (model_.kept(DividingPoint(points.at(i)))) points.kept |= 1U << i;
    }
  }
  void read_fine(OctreeCubePoints& points) const {
    const std::ptrdiff_t center = fine_.index(points.center);
    const std::array<std::ptrdiff_t, 3> stride = {points.step * points.turned[0],
                                                  points.step * points.turned[1] * fine_.row(),
                                                  points.step * points.turned[2] * fine_.slice()};
    std::size_t i = 0;
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x, ++i) {
          points.values[i] = fine_.value(center + x * stride[0] + y * stride[1] + z * stride[2]);
        }
      }
    }
    // Faces and edges of the cube have the spacing of its center.
    if (!model_.may_keep(points.step)) return;
    points.kept =
        fine_.exceeding_neighbours(points.center, points.step, points.turned) & kFacesAndEdges;
    if (model_.has_one_threshold()) return;
    for (std::uint32_t bits = kFacesAndEdges & ~points.kept; bits != 0; bits &= bits - 1) {
      const auto p = static_cast<std::size_t>(std::countr_zero(bits));
      const GridPoint at = points.at(p);
      const bool kept = model_.kept(at, points.step, fine_.error(at));
      points.kept |= static_cast<std::uint32_t>(kept) << p;
    }
  }
  // Requires coordinates that are multiples of kSpectrumSpacing.
  [[nodiscard]] float coarse_value(GridPoint p) const {
    const GridPoint at = coarse_.unit_point(p);
    if (!coarse_.contains(at)) return outside_value(info_);
    return visit_type(info_.type, [&]<typename Sample>(const Sample*) {
      Sample sample;
      std::memcpy(&sample, coarse_samples_.data() + sizeof(Sample) * coarse_.index(at),
                  sizeof(Sample));
      return static_cast<float>(sample);
    });
  }

  const PreparedModel& model_;
  const DatasetInfo& info_;
  LevelExtent coarse_;
  std::span<const std::byte> coarse_samples_;
  FineErrors fine_;
  OctreeCubeSurface surface_;
  EdgeVertices& vertices_;
};

// ---- cubes

// Appends the surface of the cube, its children's first, and cuts off tiles if it is too large.
template <typename Source>
void collect(Source& source, const OctreeCube& cube, CubeSurfaceBuilder& out) {
  const std::size_t begin = out.triangles();
  ChildRanges ranges{};
  const unsigned refined = source.refined_children(cube);
  for (int i = 0; i < 8; ++i) {
    ranges[static_cast<std::size_t>(i)] = out.triangles();
    if ((refined >> i & 1U) != 0) collect(source, cube.child(i), out);
  }
  ranges[8] = out.triangles();
  const OctreeCubeSurface::Counts own = source.append_own(cube, refined, out.mesh());
  out.count(own.tetrahedra, own.active_tetrahedra);
  out.cut_off(cube, begin, ranges);
}

template <typename Source>
CubeSurface collected(Source& source, const OctreeCube& cube, const SurfaceOptions& options,
                      LatticeMesh& mesh) {
  CubeSurfaceBuilder out(options.lattice_resolution, options.max_triangles, mesh);
  collect(source, cube, out);
  return out.take();
}

template <typename Source>
CubeSurface joined(Source& source, const OctreeCube& cube, std::vector<CubeSurface> children,
                   const SurfaceOptions& options) {
  LatticeMesh mesh;
  CubeSurfaceBuilder out(options.lattice_resolution, options.max_triangles, mesh);
  ChildRanges ranges{};
  for (std::size_t i = 0; i < 8; ++i) {
    ranges[i] = out.triangles();
    out.append(std::move(children[i]), cube.child(static_cast<int>(i)));
  }
  ranges[8] = out.triangles();
  LatticeMesh own;
  const OctreeCubeSurface::Counts counts =
      source.append_own(cube, source.refined_children(cube), own);
  out.append(own);
  out.count(counts.tetrahedra, counts.active_tetrahedra);
  out.cut_off(cube, 0, ranges);
  return out.take();
}

}  // namespace

CubeSurface surface_in_cube(const Model& model, const Field& field, const OctreeCube& cube,
                            const SurfaceOptions& options) {
  return field.visit([&](const auto& sampled) {
    FieldSource source(model, field.grid(), sampled, options);
    LatticeMesh mesh;
    return collected(source, cube, options, mesh);
  });
}

CubeSurface join_children(const Model& model, const Field& field, const OctreeCube& cube,
                          std::vector<CubeSurface> children, const SurfaceOptions& options) {
  return field.visit([&](const auto& sampled) {
    FieldSource source(model, field.grid(), sampled, options);
    return joined(source, cube, std::move(children), options);
  });
}

CubeSurface surface_in_cube(const PreparedModel& model, const OctreeCube& cube,
                            const SurfaceOptions& options, CubeMemory& memory) {
  PreparedSource source(model, options, memory);
  source.load(cube);
  return collected(source, cube, options, memory.mesh);
}

CubeSurface join_children(const PreparedModel& model, const OctreeCube& cube,
                          std::vector<CubeSurface> children, const SurfaceOptions& options) {
  CubeMemory memory;  // Between the children there are no points finer than the spectrum.
  PreparedSource source(model, options, memory);
  source.load_own(cube);
  return joined(source, cube, std::move(children), options);
}

bool is_refined(const PreparedModel& model, const OctreeCube& cube) {
  return cube.exponent == model.volume().info.grid_exponent || model.kept(center(cube));
}

std::vector<TileMesh> finished_tiles(CubeSurface root, const OctreeCube& root_cube) {
  std::vector<TileMesh> tiles = std::move(root.tiles);
  std::vector<std::uint32_t> number_of;
  if (const std::size_t remaining = root.rest.triangles.size(); remaining > 0) {
    tiles.push_back({root_cube, part_of(root.rest, 0, remaining, number_of)});
  }
  std::sort(tiles.begin(), tiles.end(),
            [](const auto& a, const auto& b) { return a.cube < b.cube; });
  return tiles;
}

}  // namespace multitetra

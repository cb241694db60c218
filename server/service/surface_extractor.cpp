#include "server/service/surface_extractor.hpp"

#include <algorithm>
#include <utility>

#include "server/core/leaves.hpp"

namespace multitetra {

namespace {

// The refined cubes of one size: what can be extracted independently.
void append_refined_cubes(const Model& model, const Grid& grid, const OctreeCube& cube,
                          int exponent, std::vector<OctreeCube>& cubes) {
  if (cube.exponent == exponent) {
    cubes.push_back(cube);
    return;
  }
  for (int i = 0; i < 8; ++i) {
    if (is_refined(model, grid, cube.child(i)))
      append_refined_cubes(model, grid, cube.child(i), exponent, cubes);
  }
}

// Joins the surfaces of those cubes, which come in the order of append_refined_cubes, up to `cube`.
CubeSurface join(const Model& model, const Field& field, const OctreeCube& cube, int exponent,
                 const SurfaceOptions& options, std::vector<CubeSurface>::iterator& next) {
  if (cube.exponent == exponent) return std::move(*next++);
  std::vector<CubeSurface> children(8);
  for (int i = 0; i < 8; ++i) {
    if (is_refined(model, field.grid(), cube.child(i))) {
      children[static_cast<std::size_t>(i)] =
          join(model, field, cube.child(i), exponent, options, next);
    }
  }
  return join_children(model, field, cube, std::move(children), options);
}

}  // namespace

SurfaceExtractor::SurfaceExtractor(DatasetPtr dataset, std::shared_ptr<ErrorsCache> cache)
    : dataset_(std::move(dataset)),
      field_(dataset_->volume, dataset_->info.outside, dataset_->info.margin),
      errors_(cache ? std::move(cache) : std::make_shared<ErrorsCache>(kDefaultErrorsCacheBytes)) {}

std::shared_ptr<const Model> SurfaceExtractor::model(const StepRequest& step,
                                                     std::stop_token stop) const {
  const IsosurfaceRequest& request = step.request;
  const double unit = request.unit == LengthUnit::kVoxel ? voxel_length(dataset_->info) : 1.0;
  return std::make_shared<ErrorBasedModel>(
      errors_->get(field_, request, stop),
      ModelOptions{.thresholds = ThresholdMap::everywhere(request.error * unit),
                   .topology_tolerance = request.topology_tolerance,
                   .finest_spacing = step.finest_spacing});
}

TiledSurface SurfaceExtractor::surface(const Model& model, const SurfaceOptions& options,
                                       std::stop_token stop) const {
  const OctreeCube root = root_cube(field_.grid());
  // Enough cubes to keep all threads busy to the end, large enough that joining them costs little.
  const int exponent = std::clamp(root.exponent - 3, std::min(root.exponent, 4), 6);
  std::vector<OctreeCube> cubes;
  append_refined_cubes(model, field_.grid(), root, exponent, cubes);
  std::vector<CubeSurface> parts(cubes.size());
  in_parallel(
      cubes.size(),
      [&](std::size_t i) { parts[i] = surface_in_cube(model, field_, cubes[i], options); }, stop);

  auto next = parts.begin();
  CubeSurface whole = join(model, field_, root, exponent, options, next);
  TiledSurface surface{
      .tetrahedra = whole.tetrahedra, .active_tetrahedra = whole.active_tetrahedra, .tiles = {}};
  std::vector<CubeSurface::Piece> pieces = finished_tiles(std::move(whole), root);
  surface.tiles.resize(pieces.size());
  in_parallel(
      pieces.size(),
      [&](std::size_t i) {
        surface.tiles[i] = {pieces[i].cube,
                            index_triangles(pieces[i].triangles, options.lattice_resolution)};
        pieces[i].triangles = {};
      },
      stop);
  return surface;
}

TiledSurface SurfaceExtractor::extract(const StepRequest& step, std::stop_token stop) const {
  return surface(
      *model(step, stop),
      {.isovalue = step.request.isovalue, .lattice_resolution = step.request.lattice_resolution},
      stop);
}

std::vector<EncodedTile> encode_tiles(const TiledSurface& surface, std::stop_token stop) {
  std::vector<EncodedTile> encoded(surface.tiles.size());
  in_parallel(
      encoded.size(),
      [&](std::size_t i) {
        encoded[i] = encode_tile(surface.tiles[i].mesh, surface.tiles[i].cube);
      },
      stop);
  return encoded;
}

}  // namespace multitetra

// Whole isosurfaces by the reference extractor, for tests of guarantees.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/surface/tiling.hpp"

namespace multitetra::testing {

struct Case {
  double isovalue = 0;
  double threshold = 0;  // World units.
  ErrorMeasure error_measure = ErrorMeasure::kPaper;
  TopologyRule rule = TopologyRule::kPaper;
  double topology_tolerance = 0;
  std::int32_t finest_spacing = 1;
  int lattice_resolution = kDefaultLatticeResolution;
  LocalThresholds thresholds = {};  // Local thresholds, in world units.
};

struct Surface {
  std::uint64_t tetrahedra = 0;
  std::uint64_t active_tetrahedra = 0;
  LatticeMesh mesh;
  MeshTopology topology;
};

// Returns what coordinates of a volume require.
inline DatasetInfo info_of(const Volume& volume, std::optional<double> outside,
                           std::int32_t margin) {
  DatasetInfo info;
  info.dims = volume.dims;
  info.spacing = volume.spacing;
  info.index_to_world = volume.index_to_world;
  info.outside = outside;
  info.margin = margin;
  info.grid_exponent = grid_exponent_for(volume.dims, margin);
  return info;
}

inline DataBorder border_of(const Volume& volume, std::optional<double> outside,
                            std::int32_t margin, int resolution, double topology_tolerance) {
  return data_border(info_of(volume, outside, margin), resolution, topology_tolerance);
}

inline Surface surface_of_model(const Model& model, const Field& field, double isovalue,
                                const DataBorder& border,
                                int resolution = kDefaultLatticeResolution) {
  const OctreeCube root = root_cube(field.grid());
  CubeSurface in_root = surface_in_cube(
      model, field, root,
      {.isovalue = isovalue, .lattice_resolution = resolution, .max_triangles = SIZE_MAX});
  Surface surface{.tetrahedra = in_root.tetrahedra,
                  .active_tetrahedra = in_root.active_tetrahedra,
                  .mesh = {},
                  .topology = {}};
  surface.mesh = std::move(in_root.rest);
  surface.topology = topology(surface.mesh, border);
  return surface;
}

// Computes the errors of one isovalue, then surfaces for any number of thresholds.
class ReferenceIsosurfaces {
 public:
  ReferenceIsosurfaces(const Volume& volume, std::optional<double> outside, std::int32_t margin)
      : volume_(volume), outside_(outside), margin_(margin), field_(volume, outside, margin) {}

  [[nodiscard]] const Field& field() const { return field_; }
  [[nodiscard]] DatasetInfo info() const { return info_of(volume_, outside_, margin_); }

  [[nodiscard]] Surface operator()(const Case& c) {
    return surface_of_model(
        model(c), field_, c.isovalue,
        border_of(volume_, outside_, margin_, c.lattice_resolution, c.topology_tolerance),
        c.lattice_resolution);
  }

  [[nodiscard]] ErrorBasedModel model(const Case& c) {
    const auto key = std::tuple(c.isovalue, c.error_measure, c.rule);
    if (!errors_ || key != key_) {
      errors_ = std::make_shared<SaturatedErrors>(field_, c.isovalue, c.error_measure, c.rule);
      key_ = key;
    }
    const IsosurfaceRequest request{
        .error = c.threshold, .unit = ErrorUnit::kWorld, .thresholds = c.thresholds};
    return {errors_,
            {.thresholds = ThresholdMap(request, info()),
             .topology_tolerance = c.topology_tolerance,
             .finest_spacing = c.finest_spacing}};
  }

 private:
  const Volume& volume_;
  std::optional<double> outside_;
  std::int32_t margin_;
  Field field_;
  std::shared_ptr<const SaturatedErrors> errors_;
  std::tuple<double, ErrorMeasure, TopologyRule> key_;
};

}  // namespace multitetra::testing

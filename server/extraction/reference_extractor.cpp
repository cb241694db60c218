#include "server/extraction/reference_extractor.hpp"

#include <algorithm>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/fine_errors/spectrum_model.hpp"
#include "server/extraction/detail/parallel_surface.hpp"
#include "server/extraction/detail/simplified_surface.hpp"

namespace multitetra {
namespace {

class FieldCubes : public CubeExtractor {
 public:
  FieldCubes(const Model& model, const Field& field, const SurfaceOptions& options)
      : model_(model), field_(field), options_(options) {}

  [[nodiscard]] bool is_refined(const OctreeCube& cube) const override {
    return multitetra::is_refined(model_, field_.grid(), cube);
  }
  [[nodiscard]] CubeSurface surface_in(const OctreeCube& cube) const override {
    return surface_in_cube(model_, field_, cube, options_);
  }
  [[nodiscard]] CubeSurface join(const OctreeCube& cube,
                                 std::vector<CubeSurface> children) const override {
    return join_children(model_, field_, cube, std::move(children), options_);
  }

 private:
  const Model& model_;
  const Field& field_;
  const SurfaceOptions& options_;
};

std::shared_ptr<const SaturatedErrors> exact_errors(const Field& field, const StepRequest& step,
                                                    const std::stop_token& stop) {
  const IsosurfaceRequest& request = step.request;
  return std::make_shared<const SaturatedErrors>(
      field, request.isovalue, request.error_measure, request.topology_rule,
      [&stop](std::size_t count, const std::function<void(std::size_t)>& body) {
        in_parallel(count, body, stop);
      },
      step.finest_spacing);
}

}  // namespace

ResolvedStep resolved_step(const StepRequest& step, const DatasetInfo& info,
                           const std::stop_token& stop) {
  return {step, info, [&stop] { throw_if_stopped(stop); }};
}

ReferenceExtractor::ReferenceExtractor(const PreparedVolume& dataset)
    : dataset_(dataset),
      volume_(whole_volume(dataset)),
      field_(volume_, dataset.info.outside, dataset.info.margin) {}

std::shared_ptr<const Model> ReferenceExtractor::exact_model(const ResolvedStep& spec,
                                                             std::stop_token stop) const {
  return std::make_shared<ErrorBasedModel>(exact_errors(field_, spec.step(), stop), spec.model());
}

std::shared_ptr<const Model> ReferenceExtractor::spectrum_model(const ResolvedStep& spec,
                                                                std::stop_token stop) const {
  const IsosurfaceRequest& request = spec.request();
  return std::make_shared<SpectrumModel>(
      exact_errors(field_, spec.step(), stop),
      std::make_shared<const SpectrumErrors>(dataset_, request.isovalue, request.error_measure,
                                             request.topology_rule),
      spec.model());
}

TiledMesh ReferenceExtractor::surface(const Model& model, const SurfaceOptions& options,
                                      std::stop_token stop, const TakeTile& take) const {
  const OctreeCube root = root_cube(field_.grid());
  const int exponent = std::clamp(root.exponent - 3, std::min(root.exponent, 4), 6);
  return extract_in_parallel(FieldCubes(model, field_, options), root, exponent, stop, take);
}

TiledMesh ReferenceExtractor::extract(const ResolvedStep& spec, const Model& model,
                                      std::stop_token stop) const {
  const SurfaceOptions options{.isovalue = spec.request().isovalue,
                               .lattice_resolution = spec.request().lattice_resolution};
  return extract_simplified(spec, dataset_.info.grid_exponent, stop, [&](const TakeTile& take) {
    return surface(model, options, stop, take);
  });
}

TiledMesh ReferenceExtractor::extract(const ResolvedStep& spec, std::stop_token stop) const {
  return extract(spec, *exact_model(spec, stop), stop);
}

}  // namespace multitetra

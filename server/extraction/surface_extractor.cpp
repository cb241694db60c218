#include "server/extraction/surface_extractor.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/core/fine_errors/prepared_model.hpp"
#include "server/extraction/detail/parallel_surface.hpp"
#include "server/extraction/detail/prefetch_bricks.hpp"
#include "server/extraction/detail/simplified_surface.hpp"
#include "server/extraction/reference_extractor.hpp"

namespace multitetra {
namespace {

class PreparedCubes : public CubeExtractor {
 public:
  PreparedCubes(const PreparedModel& model, const SurfaceOptions& options, CubeMemoryPool& pool)
      : model_(model), options_(options), pool_(pool) {}

  void will_extract(std::span<const OctreeCube> cubes) const override {
    prefetch_bricks(model_.volume(), cubes, model_.fine_options().finest_spacing);
  }
  [[nodiscard]] bool is_refined(const OctreeCube& cube) const override {
    return multitetra::is_refined(model_, cube);
  }
  [[nodiscard]] CubeSurface surface_in(const OctreeCube& cube) const override {
    CubeMemoryPool::Lease lease(pool_);
    return surface_in_cube(model_, cube, options_, lease.memory());
  }
  [[nodiscard]] CubeSurface join(const OctreeCube& cube,
                                 std::vector<CubeSurface> children) const override {
    return join_children(model_, cube, std::move(children), options_);
  }

 private:
  const PreparedModel& model_;
  const SurfaceOptions& options_;
  CubeMemoryPool& pool_;
};

// Cubes are large enough that the errors around them, which neighbours compute too, cost little,
// and numerous enough to keep all threads busy to the end.
int cube_exponent(int grid_exponent) {
  constexpr int kCubeExponent = 6;  // The data of FineErrors then fits into processor caches.
  return std::clamp(grid_exponent - 2, kSpectrumExponent + 1, kCubeExponent);
}

// Returns a cube that contains everything extracted.
OctreeCube root_of(const ResolvedStep& spec, const DatasetInfo& info) {
  const std::optional<OctreeNode>& cell = spec.request().cell;
  return cell && info.grid_exponent > kSpectrumExponent ? cell->cube
                                                        : root_cube(Grid(info.grid_exponent));
}

}  // namespace

CubeMemoryPool::Lease::Lease(CubeMemoryPool& pool) : pool_(pool) {
  {
    const std::lock_guard lock(pool_.mutex_);
    if (!pool_.free_.empty()) {
      memory_ = std::move(pool_.free_.back());
      pool_.free_.pop_back();
    }
  }
  if (!memory_) memory_ = std::make_unique<CubeMemory>();
}

CubeMemoryPool::Lease::~Lease() {
  const std::lock_guard lock(pool_.mutex_);
  pool_.free_.push_back(std::move(memory_));
}

PreparedModel prepared_model(const PreparedVolume& volume, const ResolvedStep& spec,
                             std::shared_ptr<const SpectrumErrors> spectrum) {
  const IsosurfaceRequest& request = spec.request();
  return {volume,
          {.isovalue = request.isovalue,
           .error_measure = request.error_measure,
           .rule = request.topology_rule,
           .topology_tolerance = request.topology_tolerance},
          spec.model(),
          std::move(spectrum)};
}

SurfaceExtractor::SurfaceExtractor(DatasetPtr dataset, std::shared_ptr<CubeMemoryPool> pool)
    : dataset_(std::move(dataset)),
      pool_(pool ? std::move(pool) : std::make_shared<CubeMemoryPool>()) {}

TiledMesh SurfaceExtractor::extract(const StepRequest& step, std::stop_token stop) const {
  return extract(resolved_step(step, dataset_->info, stop), stop);
}

TiledMesh SurfaceExtractor::extract(const ResolvedStep& spec, std::stop_token stop) const {
  TiledMesh surface =
      extract_simplified(spec, root_of(spec, dataset_->info).exponent, stop,
                         [&](const TakeTile& take) { return extract_model(spec, stop, take); });
  if (dataset_->check) dataset_->check();
  return surface;
}

TiledMesh SurfaceExtractor::extract_model(const ResolvedStep& spec, std::stop_token stop,
                                          const TakeTile& take) const {
  const DatasetInfo& info = dataset_->info;
  const SurfaceOptions options{.isovalue = spec.request().isovalue,
                               .lattice_resolution = spec.request().lattice_resolution};
  if (info.grid_exponent <= kSpectrumExponent) {
    // A grid of at most eight steps has no spectrum, and a pass over it is cheap.
    const ReferenceExtractor reference(*dataset_);
    return reference.surface(*reference.exact_model(spec, stop), options, stop, take);
  }
  const PreparedModel model = prepared_model(*dataset_, spec);
  return extract_in_parallel(PreparedCubes(model, options, *pool_), root_of(spec, info),
                             cube_exponent(info.grid_exponent), stop, take);
}

}  // namespace multitetra

// The isosurface of a prepared dataset for one step, divided into tiles: runs the pure parts of
// core on all threads.
//
// Results depend only on the dataset and the step: errors come from the error spectrum and, below
// its spacing, from the samples. No state is kept between isovalues.
#pragma once

#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "server/core/fine_errors/prepared_model.hpp"
#include "server/core/planning/resolved_step.hpp"
#include "server/core/surface/tiling.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/tiled_surface.hpp"

namespace multitetra {

// A thread-safe pool of working memory.
class CubeMemoryPool {
 public:
  // Owns memory while it is in use and returns it when destroyed.
  class Lease {
   public:
    explicit Lease(CubeMemoryPool& pool);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    [[nodiscard]] CubeMemory& memory() { return *memory_; }

   private:
    CubeMemoryPool& pool_;
    std::unique_ptr<CubeMemory> memory_;
  };

 private:
  std::mutex mutex_;  // Guards free_.
  std::vector<std::unique_ptr<CubeMemory>> free_;
};

// Returns the model of a step. The volume must outlive it. Requires a grid of more than
// kSpectrumSpacing steps a side.
[[nodiscard]] PreparedModel prepared_model(
    const PreparedVolume& volume, const ResolvedStep& spec,
    std::shared_ptr<const SpectrumErrors> spectrum = nullptr);

// Thread-safe.
class SurfaceExtractor {
 public:
  // Extractors may share a pool.
  explicit SurfaceExtractor(DatasetPtr dataset, std::shared_ptr<CubeMemoryPool> pool = nullptr);

  [[nodiscard]] const PreparedVolume& dataset() const { return *dataset_; }
  [[nodiscard]] CubeMemoryPool& pool() const { return *pool_; }

  // Requires a validated request. Throws Cancelled soon after `stop` is triggered, and
  // DatasetFileError if the dataset is damaged.
  [[nodiscard]] TiledMesh extract(const ResolvedStep& spec, std::stop_token stop = {}) const;
  [[nodiscard]] TiledMesh extract(const StepRequest& step, std::stop_token stop = {}) const;
  // Returns the surface before simplification. With `take`, its tiles are passed to it instead.
  [[nodiscard]] TiledMesh extract_model(const ResolvedStep& spec, std::stop_token stop = {},
                                        const TakeTile& take = nullptr) const;

 private:
  DatasetPtr dataset_;
  std::shared_ptr<CubeMemoryPool> pool_;
};

}  // namespace multitetra

// The isosurface of a prepared dataset for one step, cut into tiles: the pure parts of core, run on
// all threads.
//
// Every answer is a function of the dataset and the step alone: errors come from the error spectrum
// and, where the model goes below its spacing, from the samples there. Nothing is kept from one
// isovalue to the next.
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

// A pool of working memory, shared by all threads.
class CubeMemoryPool {
 public:
  // Owns memory while it is in use; gives it back at its end.
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

// The model of a step. The volume must outlive it; requires a grid of more than kSpectrumSpacing
// steps a side.
[[nodiscard]] PreparedModel prepared_model(
    const PreparedVolume& volume, const ResolvedStep& spec,
    std::shared_ptr<const SpectrumErrors> spectrum = nullptr);

// Safe to use from several threads at once.
class SurfaceExtractor {
 public:
  // Extractors may share a pool.
  explicit SurfaceExtractor(DatasetPtr dataset, std::shared_ptr<CubeMemoryPool> pool = nullptr);

  [[nodiscard]] const PreparedVolume& dataset() const { return *dataset_; }
  [[nodiscard]] CubeMemoryPool& pool() const { return *pool_; }

  // Requires a validated request. Throws Cancelled soon after `stop` is triggered, and
  // DatasetFileError when the dataset turns out to be damaged.
  [[nodiscard]] TiledSurface extract(const ResolvedStep& spec, std::stop_token stop = {}) const;
  [[nodiscard]] TiledSurface extract(const StepRequest& step, std::stop_token stop = {}) const;
  // The same before it is simplified.
  [[nodiscard]] TiledSurface extract_model(const ResolvedStep& spec,
                                           std::stop_token stop = {}) const;

 private:
  DatasetPtr dataset_;
  std::shared_ptr<CubeMemoryPool> pool_;
};

}  // namespace multitetra

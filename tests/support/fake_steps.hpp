// A source of steps controlled by a test; nothing is extracted.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/wire/messages.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "tests/support/octahedra.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra::testing {

using MakeStep = std::function<EncodedStep(const StepRequest&, std::stop_token)>;

inline EncodedStep octahedron_step(const StepRequest& step) {
  const bool is_fine = step.request.topology_tolerance == 0;
  const int resolution = step.request.lattice_resolution;
  return {.tetrahedra = 100,
          .active_tetrahedra = 10,
          .tiles = is_fine ? fine_tiles(resolution) : coarse_tiles(resolution)};
}

// Steps with a coarser finest spacing are much smaller; full resolution has one megabyte.
inline SizeEstimates fake_sizes() {
  const auto size_at = [](std::int32_t finest) {
    const double triangles = 1e6 / (finest * finest * finest);
    return SurfaceSize{.triangles = triangles, .bytes = triangles, .extracted = triangles};
  };
  return {.of = [=](const StepRequest& step) { return size_at(step.finest_spacing); },
          .rough = [=](const IsosurfaceRequest&) { return size_at(1); }};
}

class FakeSteps : public SurfaceProvider {
 public:
  explicit FakeSteps(
      std::string name, MakeStep make = [](const StepRequest& step,
                                           std::stop_token) { return octahedron_step(step); })
      : info_(octahedra_info(std::move(name))), make_(std::move(make)) {
    info_.dims = {65, 65, 65};  // Large enough for previews.
    info_.grid_exponent = 6;
  }

  [[nodiscard]] const DatasetInfo& info() const override { return info_; }
  [[nodiscard]] EncodedStep make(const StepRequest& step, std::stop_token stop) const override {
    return make_(step, std::move(stop));
  }
  // Previews are a small part of the whole.
  [[nodiscard]] SizeEstimates sizes(std::stop_token, SizeAccuracy) const override {
    return fake_sizes();
  }

 private:
  DatasetInfo info_;
  MakeStep make_;
};

// Runs until stopped, like a very long extraction.
inline MakeStep endless(Count& running) {
  return [&running](const StepRequest&, const std::stop_token& stop) -> EncodedStep {
    ++running;
    Gate().pass(stop);
    --running;
    throw Cancelled{};
  };
}

// Makes `count` tiles of `bytes` arbitrary bytes, which no client decodes.
inline MakeStep heavy(std::size_t count, std::size_t bytes) {
  return [count, bytes](const StepRequest&, const std::stop_token&) {
    const auto payload = std::make_shared<const std::string>(bytes, 'x');
    EncodedStep step;
    for (std::size_t i = 0; i < count; ++i) {
      const TileSummary summary{.cube = {.exponent = 0, .x = static_cast<std::int32_t>(i)},
                                .digest = {1, i},
                                .triangles = 1,
                                .vertices = 3,
                                .bytes = static_cast<std::uint32_t>(bytes)};
      step.tiles.push_back({.summary = summary, .payload = payload});
    }
    return step;
  };
}

inline std::shared_ptr<DatasetCatalogue> catalogue_of(
    std::shared_ptr<const SurfaceProvider> source) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(std::move(source));
  return catalogue;
}
inline std::shared_ptr<DatasetCatalogue> fake_catalogue(std::string name = "fake") {
  return catalogue_of(std::make_shared<FakeSteps>(std::move(name)));
}

// Returns a request for a surface of a fake dataset.
inline OpenStream open_fake(std::uint64_t id, std::string dataset = "fake",
                            StepPolicy steps = StepPolicy::kFinalOnly) {
  return {.request_id = id,
          .dataset = std::move(dataset),
          .request = {.isovalue = 1},
          .steps = steps,
          .cached_tile_digests = {}};
}

}  // namespace multitetra::testing

#include "server/core/planning/refinement_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "server/core/planning/shell_steps.hpp"

namespace multitetra {
namespace {

DatasetInfo dataset(std::int32_t samples_a_side, double spacing = 1) {
  DatasetInfo info;
  info.dims = {samples_a_side, samples_a_side, samples_a_side};
  info.spacing = {spacing, spacing, spacing};
  info.grid_exponent = grid_exponent_for(info.dims, 0);
  return info;
}

// A surface with `triangles` triangles at full resolution and f^-2 of them at finest spacing f.
struct Surface {
  double triangles = 2e6;
  double remaining_share = 0.1;  // After simplification.

  [[nodiscard]] SizeEstimates sizes() const {
    const auto size_at = [*this](const IsosurfaceRequest& request, double finest) {
      const double extracted = triangles / (finest * finest);
      const double left = request.simplify ? remaining_share * extracted : extracted;
      return SurfaceSize{.triangles = left, .bytes = 2 * left, .extracted = extracted};
    };
    return {
        .of = [=](const StepRequest& step) { return size_at(step.request, step.finest_spacing); },
        .rough = [=](const IsosurfaceRequest& request) { return size_at(request, 1); }};
  }
};

const IsosurfaceRequest kSimplified = {.error = 0.5, .simplify = true};
constexpr CostEstimates kFast = {.bytes_per_second = 1e9};
constexpr CostEstimates kSlow = {.bytes_per_second = 1.25e5};  // 1 Mbit/s.

struct Shown {
  StepRequest step;
  double server = 0;  // Seconds.
  double link = 0;
};

// Returns all steps of the stream, planned and measured as on the server.
std::vector<Shown> stream(const IsosurfaceRequest& request, const DatasetInfo& info,
                          const Surface& surface = {}, const CostEstimates& costs = {},
                          const PlanLimits& limits = {}) {
  const SizeEstimates sizes = surface.sizes();
  std::vector<DeliveredStep> delivered;
  std::vector<Shown> steps;
  for (;;) {
    const PlannedStep next = next_step(request, limits, delivered, info, sizes, costs);
    const SurfaceSize size = sizes.of(next.step);
    const double seconds = costs.server_seconds(size, form_of(next.step));
    steps.push_back({next.step, seconds, costs.link_seconds(size)});
    if (next.is_final) return steps;
    delivered.push_back({.step = next.step, .size = size, .seconds = seconds});
    if (steps.size() > 20) throw std::runtime_error("the stream has no end");
  }
}

TEST(RefinementPlan, EndsWithExactlyTheRequest) {
  for (const double error : {0.0, 0.5, 3.0, 100.0}) {
    for (const bool previews : {false, true}) {
      const IsosurfaceRequest request{
          .isovalue = 3, .error = error, .topology_tolerance = 1, .lattice_resolution = 7};
      const auto steps = stream(request, dataset(129), {}, {}, {.previews = previews});
      EXPECT_EQ(steps.back().step, (StepRequest{.request = request, .finest_spacing = 1}));
    }
  }
}

TEST(RefinementPlan, HasPreviewsThatConvergeToTheRequest) {
  const auto steps = stream(kSimplified, dataset(257));
  ASSERT_GE(steps.size(), 3U);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    const StepRequest& coarse = steps[i].step;
    const StepRequest& fine = steps[i + 1].step;
    EXPECT_EQ(coarse.request.isovalue, kSimplified.isovalue);
    if (coarse.finest_spacing == 1) continue;  // The certified step.
    EXPECT_GE(coarse.request.thresholds.error_floor, 2 * fine.request.thresholds.error_floor);
    EXPECT_GT(coarse.request.topology_tolerance, fine.request.topology_tolerance);
    EXPECT_GE(coarse.finest_spacing, 2 * fine.finest_spacing);
  }
}

TEST(RefinementPlan, HasNoPreviewUnlessRequested) {
  EXPECT_EQ(stream(kSimplified, dataset(257), {}, {}, {.previews = false}).size(), 1U);
}

// The time limits hold for surfaces and grids of any size, on any link.
TEST(RefinementPlan, StartsSoonAndDelaysTheFinalStepByAtMostAFifth) {
  for (const std::int32_t side : {65, 129, 257, 513, 2049}) {
    for (const double triangles : {1e5, 1e6, 1e7}) {
      for (const double link : {1.25e5, 1.25e6, 1e9}) {
        for (const bool simplify : {false, true}) {
          SCOPED_TRACE(std::to_string(side) + ", " + std::to_string(triangles) + ", " +
                       std::to_string(link) + (simplify ? ", simplified" : ""));
          const IsosurfaceRequest request = {.error = 0.5, .simplify = simplify};
          const auto steps =
              stream(request, dataset(side), {.triangles = triangles}, {.bytes_per_second = link});
          const bool can_be_coarser = side / steps[0].step.finest_spacing >= 16;
          if (can_be_coarser) {
            EXPECT_LE(steps[0].server, kFirstServerSeconds);
            EXPECT_LE(steps[0].link, kFirstLinkSeconds);
          }
          const double whole = steps.back().server + steps.back().link;
          for (std::size_t i = 1; i + 1 < steps.size(); ++i) {
            const bool is_certified = steps[i].step.finest_spacing == 1;
            const double share = is_certified ? kCertifiedShare : kPreviewShare;
            EXPECT_LE(steps[i].server + steps[i].link, 1.3 * share * whole)
                << "sizes are forecasts";
          }
        }
      }
    }
  }
}

TEST(RefinementPlan, LimitsEachStepByTheTimeOfAllBefore) {
  const auto steps = stream(kSimplified, dataset(513), {.triangles = 1e7});
  double before = steps[0].server + steps[0].link;
  for (std::size_t i = 1; i + 1 < steps.size() && steps[i].step.finest_spacing > 1; ++i) {
    const double seconds = steps[i].server + steps[i].link;
    EXPECT_LE(seconds, 1.1 * kMaxStepGrowth * std::max(before, kFirstServerSeconds));
    before += seconds;
  }
}

TEST(RefinementPlan, SimplifiesPreviewsOnlyOnASlowLink) {
  const Surface large = {.triangles = 4e6};
  const auto fast = stream(kSimplified, dataset(513), large, kFast);
  for (const auto& one : fast) {
    EXPECT_EQ(one.step.request.simplify, &one == &fast.back());
  }
  bool is_any_simplified = false;
  const auto steps = stream(kSimplified, dataset(513), large, kSlow);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    is_any_simplified = is_any_simplified || steps[i].step.request.simplify;
  }
  EXPECT_TRUE(is_any_simplified);
  for (const auto& one : stream({.error = 0.5}, dataset(513), large, kSlow)) {
    EXPECT_FALSE(one.step.request.simplify) << "it was not requested";
  }
}

TEST(RefinementPlan, KeepsPreviewsWithinTheBudget) {
  IsosurfaceRequest request = kSimplified;
  const Surface large = {.triangles = 4e6};
  for (const std::uint64_t most : {1'000U, 20'000U, 100'000U}) {
    request.max_triangles = most;
    request.max_bytes = 0;
    for (const auto& one : stream(request, dataset(1025), large, kFast)) {
      if (one.step.finest_spacing == 1) continue;
      EXPECT_LE(large.sizes().of(one.step).triangles, 1.3 * static_cast<double>(most));
    }
    request.max_triangles = 0;
    request.max_bytes = 2 * most;
    for (const auto& one : stream(request, dataset(1025), large, kFast)) {
      if (one.step.finest_spacing == 1) continue;
      EXPECT_LE(large.sizes().of(one.step).bytes, 2.6 * static_cast<double>(most));
    }
  }
}

TEST(RefinementPlan, StartsFinerOnAFasterLink) {
  const Surface large = {.triangles = 2e7};
  const auto fast = stream(kSimplified, dataset(2049), large, kFast);
  const auto slow = stream(kSimplified, dataset(2049), large, kSlow);
  EXPECT_LT(fast[0].step.finest_spacing, slow[0].step.finest_spacing);
}

TEST(RefinementPlan, ReadsOnlyTheSpectrumForTheFirstPreview) {
  for (const std::int32_t side : {65, 129, 257, 513}) {
    EXPECT_GE(stream(kSimplified, dataset(side)).front().step.finest_spacing, 8);
  }
}

TEST(RefinementPlan, FetchesLittleOfARemoteDatasetForTheFirstPreview) {
  SizeEstimates sizes = Surface{.triangles = 1000}.sizes();  // Small enough to be sent in one step.
  sizes.to_fetch = [](std::int32_t finest) {
    return (std::uint64_t{30} << 20) / static_cast<std::uint64_t>(finest * finest);
  };
  sizes.of = [of = sizes.of](const StepRequest& step) {
    EXPECT_GE(step.finest_spacing, 16);
    return of(step);
  };
  sizes.rough = [rough = sizes.rough](const IsosurfaceRequest& request) {
    ADD_FAILURE() << "the size of the whole is looked for";
    return rough(request);
  };
  const PlannedStep first = next_step(kSimplified, {}, {}, dataset(1025), sizes, kFast);
  EXPECT_FALSE(first.is_final);
  EXPECT_EQ(first.step.finest_spacing, 16);
  sizes.to_fetch = [](std::int32_t finest) { return finest < 32 ? ~std::uint64_t{0} : 0; };
  EXPECT_EQ(next_step(kSimplified, {}, {}, dataset(1025), sizes, kFast).step.finest_spacing, 32);
}

TEST(RefinementPlan, StartsCoarserForALargerSurface) {
  const auto small = stream(kSimplified, dataset(513), {.triangles = 1e6});
  const auto large = stream(kSimplified, dataset(513), {.triangles = 1e8});
  EXPECT_LT(small.front().step.finest_spacing, large.front().step.finest_spacing);
}

TEST(RefinementPlan, SendsASmallSurfaceAtOnce) {
  EXPECT_EQ(stream(kSimplified, dataset(257), {.triangles = 1e4}).size(), 1U);
}

// Returns whether the step before the last is the request's own model without simplification.
bool has_certified(const std::vector<Shown>& steps, const IsosurfaceRequest& request) {
  if (steps.size() < 2) return false;
  const StepRequest& step = steps[steps.size() - 2].step;
  if (step.finest_spacing > 1) return false;
  IsosurfaceRequest unsimplified = request;
  unsimplified.simplify = false;
  EXPECT_EQ(step.request, unsimplified);
  return true;
}

TEST(RefinementPlan, SendsTheCertifiedPreviewOnAFastLink) {
  EXPECT_TRUE(has_certified(stream(kSimplified, dataset(257), {}, kFast), kSimplified));
  const IsosurfaceRequest fine = {.error = 0.25, .lattice_resolution = 7, .simplify = true};
  EXPECT_TRUE(has_certified(stream(fine, dataset(257), {}, kFast), fine));
  EXPECT_FALSE(has_certified(stream(kSimplified, dataset(257), {}, {}), kSimplified));
  EXPECT_FALSE(has_certified(stream(kSimplified, dataset(257), {}, kSlow), kSimplified));
}

TEST(RefinementPlan, OmitsTheCertifiedPreviewIfNotAllowed) {
  const DatasetInfo info = dataset(257);
  const auto is_there = [&](const IsosurfaceRequest& request, const PlanLimits& limits,
                            const Surface& surface = {}) {
    return has_certified(stream(request, info, surface, kFast, limits), request);
  };
  EXPECT_FALSE(is_there(kSimplified, {.certified_triangles = 0}));
  EXPECT_FALSE(is_there(kSimplified, {.certified_triangles = 1e6}));
  EXPECT_FALSE(is_there(kSimplified, {}, {.triangles = 1.1 * kMaxCertifiedTriangles}));
  IsosurfaceRequest with_budget = kSimplified;
  with_budget.max_triangles = 1'000'000;
  EXPECT_FALSE(is_there(with_budget, {}));
  EXPECT_FALSE(is_there({.error = 0.5}, {})) << "the request itself is not simplified";
  EXPECT_FALSE(is_there({.error = 0, .simplify = true}, {})) << "nothing is left out";
}

// A phone and a workstation on the same link.
TEST(RefinementPlan, StartsCoarserForASlowClient) {
  const DatasetInfo info = dataset(257);
  CostEstimates slow = kFast;
  slow.client_triangles_per_second = 2e5;
  CostEstimates fast = kFast;
  fast.client_triangles_per_second = 1e8;
  EXPECT_TRUE(has_certified(stream(kSimplified, info, {}, fast), kSimplified));
  const auto steps = stream(kSimplified, info, {}, slow);
  EXPECT_FALSE(has_certified(steps, kSimplified));
  const SizeEstimates sizes = Surface{}.sizes();
  const double whole = slow.client_seconds(sizes.of(steps.back().step)) + steps.back().server;
  EXPECT_LE(slow.client_seconds(sizes.of(steps[0].step)), kFirstClientSeconds);
  for (std::size_t i = 1; i + 1 < steps.size(); ++i) {
    EXPECT_LE(slow.client_seconds(sizes.of(steps[i].step)), 1.3 * kPreviewShare * whole);
  }
  slow.client_triangles_per_second = 1e-300;
  EXPECT_EQ(stream(kSimplified, info, {}, slow).back().step, final_step(kSimplified));
}

TEST(RefinementPlan, RebuildsAPreviewFromItsName) {
  const DatasetInfo info = dataset(257);
  for (const CostEstimates& costs : {kSlow, kFast}) {
    const auto steps = stream(kSimplified, info, {}, costs);
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
      const StepRequest& step = steps[i].step;
      const Preview name = {.finest_spacing = step.finest_spacing,
                            .is_unsimplified = !step.request.simplify};
      EXPECT_EQ(preview_step(kSimplified, name, info), step);
    }
  }
}

TEST(RefinementPlan, HasNoPreviewCoarserThanTheGrid) {
  EXPECT_EQ(stream({.error = 1}, dataset(9)).size(), 1U);
  EXPECT_EQ(stream({.error = 1}, dataset(33)).size(), 1U);
}

TEST(RefinementPlan, HasPreviewsForTolerantRequests) {
  const auto steps =
      stream({.error = 1, .topology_tolerance = 1e3, .simplify = true}, dataset(257));
  ASSERT_GE(steps.size(), 2U);
  for (const auto& one : steps) EXPECT_EQ(one.step.request.topology_tolerance, 1e3);
}

TEST(RefinementPlan, HasFiniteErrorsForHugeRequests) {
  for (const auto& one : stream({.error = 1e308, .simplify = true}, dataset(513))) {
    EXPECT_TRUE(std::isfinite(one.step.request.thresholds.error_floor));
  }
}

TEST(RefinementPlan, IsTheSameInVoxelsAndWorldUnits) {
  const DatasetInfo info = dataset(257, 0.25);
  const auto voxels = stream({.error = 0.5, .unit = ErrorUnit::kVoxel}, info);
  const auto world = stream({.error = 0.5 * 0.25, .unit = ErrorUnit::kWorld}, info);
  ASSERT_EQ(voxels.size(), world.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_DOUBLE_EQ(voxels[i].step.request.thresholds.error_floor * 0.25,
                     world[i].step.request.thresholds.error_floor);
  }
}

// ---- sample shells

constexpr PlanLimits kShellsToKeep = {.shells = true};
constexpr PlanLimits kShellsToDisplay = {.shells = true, .is_display = true};
const IsosurfaceRequest kHalf = {.isovalue = 3.5, .error = 0.5, .simplify = true};

TEST(RefinementPlan, UsesShellsInPreviewsIfTheClientDecodesThem) {
  for (const auto& one : stream(kHalf, dataset(257))) EXPECT_FALSE(one.step.shell);
  const auto steps = stream(kHalf, dataset(257), {}, {}, kShellsToKeep);
  ASSERT_GE(steps.size(), 3U);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    const StepRequest& step = steps[i].step;
    ASSERT_TRUE(step.shell);
    EXPECT_FALSE(step.request.simplify);
    EXPECT_TRUE(step.finest_spacing > 1 || i + 2 == steps.size()) << "the certified one";
  }
  EXPECT_EQ(steps.back().step, final_step(kHalf))
      << "a client that keeps the mesh gets the requested step";
}

TEST(RefinementPlan, UsesTheFewestShellLevelsInPreviews) {
  const auto steps = stream(kHalf, dataset(513), {.triangles = 1e7}, kSlow, kShellsToDisplay);
  ASSERT_GE(steps.size(), 3U);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    EXPECT_EQ(steps[i].step.shell, quantized_shells(1));
  }
}

// A preview must be early enough for the user to notice; its bytes are not free.
TEST(RefinementPlan, HasOnePreviewBeforeAShortFinalStep) {
  const Surface surface = {.triangles = 3e6};
  const double seconds = CostEstimates{}.shells * surface.triangles;
  EXPECT_GT(seconds, kFirstServerSeconds);
  EXPECT_LT(seconds, kShortStepSeconds);
  EXPECT_EQ(stream(kHalf, dataset(257), surface, kFast, kShellsToDisplay).size(), 2U);
  EXPECT_GT(stream(kHalf, dataset(257), surface, kSlow, kShellsToDisplay).size(), 2U);
  EXPECT_GT(stream(kHalf, dataset(257), surface, kFast, kShellsToKeep).size(), 2U)
      << "a client that keeps the mesh waits for simplification";
}

TEST(RefinementPlan, DelaysTheFinalStepByAtMostAFifthWithShellPreviews) {
  for (const double triangles : {5e5, 2e6, 8e6}) {
    for (const double link : {1.25e5, 1.25e6, 1e9}) {
      SCOPED_TRACE(std::to_string(triangles) + ", " + std::to_string(link));
      const auto steps = stream(kHalf, dataset(513), {.triangles = triangles},
                                {.bytes_per_second = link}, kShellsToDisplay);
      const double whole = steps.back().server + steps.back().link;
      for (std::size_t i = 1; i + 1 < steps.size(); ++i) {
        EXPECT_LE(steps[i].server + steps[i].link, 1.3 * kPreviewShare * whole);
      }
    }
  }
}

TEST(RefinementPlan, EndsWithShellsIfTheyAreSoonerAndNoMeshIsKept) {
  const auto steps = stream(kHalf, dataset(257), {}, kFast, kShellsToDisplay);
  const StepRequest& last = steps.back().step;
  ASSERT_TRUE(last.shell);
  EXPECT_EQ(last.finest_spacing, 1);
  EXPECT_EQ(*last.shell, quantized_shells(1)) << "0.289 voxels are within 0.5";
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) EXPECT_GT(steps[i].step.finest_spacing, 1);
  const auto alone = stream(kHalf, dataset(257), {}, kFast,
                            {.previews = false, .shells = true, .is_display = true});
  ASSERT_EQ(alone.size(), 1U);
  EXPECT_EQ(alone[0].step, last);
}

TEST(RefinementPlan, EndsWithTheRequestIfShellsCannotAnswerIt) {
  const auto last_of = [](const IsosurfaceRequest& request, const CostEstimates& costs = kFast,
                          PlanLimits limits = kShellsToDisplay) {
    return stream(request, dataset(257), {}, costs, limits).back().step;
  };
  const auto expect_itself = [&](IsosurfaceRequest request) {
    EXPECT_EQ(last_of(request), final_step(request));
  };
  expect_itself({.isovalue = 3.5, .error = 1, .simplify = true});
  expect_itself({.isovalue = 3.5, .error = 0.5, .simplify = true, .normal_bits = 8});
  expect_itself({.isovalue = 3.5, .error = 0.5, .max_triangles = 10'000'000, .simplify = true});
  // A client that decodes triangles slowly.
  EXPECT_EQ(last_of(kHalf, {.bytes_per_second = 1e9, .client_triangles_per_second = 1e5}),
            final_step(kHalf));
  PlanLimits few = kShellsToDisplay;
  few.shell_triangles = 1000;
  EXPECT_EQ(last_of(kHalf, kFast, few), final_step(kHalf));
}

TEST(RefinementPlan, RebuildsAShellStepFromItsName) {
  const auto steps = stream(kHalf, dataset(513), {.triangles = 1e7}, {}, kShellsToKeep);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    const StepRequest& step = steps[i].step;
    EXPECT_EQ(preview_step(kHalf, {.finest_spacing = step.finest_spacing, .shell = step.shell},
                           dataset(513)),
              step);
  }
}

TEST(CertifiedShells, UsesTheCheapestLevelWithinAllThresholds) {
  DatasetInfo info = dataset(129);
  info.type = SampleType::kU16;
  const auto shell_for = [&](double error) {
    const auto step = certified_shells({.isovalue = 3.5, .error = error}, info);
    return step ? step->shell : std::nullopt;
  };
  EXPECT_EQ(shell_for(5), quantized_shells(1));
  EXPECT_EQ(shell_for(0.29), quantized_shells(1));
  EXPECT_EQ(shell_for(0.2), quantized_shells(2));
  EXPECT_EQ(shell_for(0.08), quantized_shells(4));
  EXPECT_EQ(shell_for(0.04), quantized_shells(8));
  // Error 0: exact values or those of the lattice, depending on sample bits and lattice resolution.
  constexpr ShellStep kExact = {.values = shell::ShellValues::kExact};
  constexpr ShellStep kLatticeExact = {.values = shell::ShellValues::kLatticeExact};
  EXPECT_EQ(shell_for(0), kLatticeExact);
  const auto on_fine_lattice =
      certified_shells({.isovalue = 3.5, .error = 0, .lattice_resolution = 8}, info);
  EXPECT_EQ(on_fine_lattice->shell, kExact);
  for (const SampleType type : {SampleType::kU8, SampleType::kI8}) {
    info.type = type;
    EXPECT_EQ(shell_for(0), kExact);
  }
  info.type = SampleType::kI16;
  EXPECT_EQ(shell_for(0), kLatticeExact);
  info.type = SampleType::kF32;
  EXPECT_EQ(shell_for(0), ShellStep{.values = shell::ShellValues::kLatticeExact});
  // The same quantization moves vertices farther along an axis with a larger sample spacing.
  info.spacing = {1, 1, 3};
  info.index_to_world.columns[2] = {0, 0, 3};
  EXPECT_EQ(shell_for(0.2), quantized_shells(4));
  // The smallest threshold of any region counts.
  IsosurfaceRequest request = {.isovalue = 3.5, .error = 5};
  request.thresholds.regions = {
      {.shape = BoxShape{.low = {1, 1, 1}, .high = {2, 2, 2}}, .threshold = 0}};
  const auto step = certified_shells(request, info);
  ASSERT_TRUE(step);
  EXPECT_EQ(step->shell->values, shell::ShellValues::kLatticeExact);
}

TEST(EstimatedBytes, GrowWithTheValuesOfShells) {
  const auto bits = [](const ShellStep& shell, SampleType type = SampleType::kU16) {
    const StepRequest step = {.request = {}, .shell = shell};
    EXPECT_NEAR(estimated_bytes(2e6, step, type), 1e6 / 8 * bits_per_vertex(shell, type, 5) + 250,
                1);
    return bits_per_vertex(shell, type, 5);
  };
  // Measured on public volumes: the Visible Female and the embryo.
  EXPECT_NEAR(bits(quantized_shells(1)), 1.3, 0.2);
  EXPECT_NEAR(bits(quantized_shells(8)), 2.6, 0.3);
  EXPECT_NEAR(bits({.values = shell::ShellValues::kLatticeExact}), 2.94, 0.2);
  EXPECT_NEAR(bits({.values = shell::ShellValues::kExact}), 4.64, 0.2);
  EXPECT_NEAR(bits({.values = shell::ShellValues::kExact}, SampleType::kU8), 2.89, 0.2);
}

TEST(IsEnoughToDisplay, DependsOnlyOnRequestAndStep) {
  const DatasetInfo info = dataset(129);
  const auto step_of = [&](const IsosurfaceRequest& request, std::int32_t finest, int levels) {
    return preview_step(request, {.finest_spacing = finest, .shell = quantized_shells(levels)},
                        info);
  };
  EXPECT_TRUE(is_enough_to_display(step_of(kHalf, 1, 1), kHalf, info));
  EXPECT_TRUE(is_enough_to_display(step_of(kHalf, 1, 8), kHalf, info));
  EXPECT_FALSE(is_enough_to_display(step_of(kHalf, 2, 8), kHalf, info));
  IsosurfaceRequest fine = kHalf;
  fine.error = 0.1;
  EXPECT_FALSE(is_enough_to_display(step_of(fine, 1, 2), fine, info));
  EXPECT_TRUE(is_enough_to_display(step_of(fine, 1, 4), fine, info));
  IsosurfaceRequest coarse = kHalf;
  coarse.error = 1;
  EXPECT_FALSE(is_enough_to_display(step_of(coarse, 1, 1), coarse, info));
  IsosurfaceRequest budget = kHalf;
  budget.max_bytes = 1'000'000'000;
  EXPECT_FALSE(is_enough_to_display(step_of(budget, 1, 1), budget, info));
  EXPECT_FALSE(is_enough_to_display(final_step(kHalf), kHalf, info));
}

// ---- costs

TEST(MeasuredCosts, LearnTheCostOfTrianglesOnThisMachine) {
  MeasuredCosts learned;
  for (int i = 0; i < 30; ++i) {
    learned.record(StepForm::kPlain, 1e5, CostEstimates::kSecondsPerStep + 0.02);
    learned.record(StepForm::kSimplified, 1e5, CostEstimates::kSecondsPerStep + 0.5);
    learned.record(StepForm::kIntersectionFree, 1e5, CostEstimates::kSecondsPerStep + 1);
  }
  EXPECT_NEAR(learned.costs().plain, 2e-7, 1e-9);
  EXPECT_NEAR(learned.costs().simplified, 5e-6, 1e-8);
  EXPECT_NEAR(learned.costs().intersection_free, 1e-5, 2e-8);
}

TEST(MeasuredCosts, LearnIntersectionFreeSurfacesSeparately) {
  MeasuredCosts learned;
  const IsosurfaceRequest plain{.simplify = true};
  IsosurfaceRequest intersection_free = plain;
  intersection_free.intersection_free = true;
  const StepForm form = form_of(final_step(intersection_free));
  for (int i = 0; i < 30; ++i) learned.record(form, 1e5, 1);
  const SurfaceSize size{.triangles = 1e4, .bytes = 2e4, .extracted = 1e5};
  EXPECT_NEAR(learned.costs().server_seconds(size, form), 1, 0.01);
  EXPECT_EQ(learned.costs().server_seconds(size, form_of(final_step(plain))),
            CostEstimates{}.server_seconds(size, StepForm::kSimplified));
}

TEST(MeasuredCosts, IgnoreASingleSlowStep) {
  MeasuredCosts learned;
  const double before = learned.costs().plain;
  learned.record(StepForm::kPlain, 1e5, 1000);
  EXPECT_LE(learned.costs().plain, 2 * before);
}

TEST(MeasuredCosts, IgnoreTinySteps) {
  MeasuredCosts learned;
  learned.record(StepForm::kSimplified, 100, 10);
  learned.record(StepForm::kSimplified, 0, 10);
  EXPECT_EQ(learned.costs().simplified, CostEstimates{}.simplified);
}

}  // namespace
}  // namespace multitetra

// Plans meet their budgets even when estimates are wrong.
#include "server/stream/stream_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/fake_steps.hpp"

namespace multitetra {
namespace {

using testing::FakeSteps;

// The size of a one-tile surface of about `whole` triangles that halves when the error doubles.
std::uint32_t triangles_at(const IsosurfaceRequest& request, double whole) {
  return static_cast<std::uint32_t>(whole /
                                    std::max({1.0, request.error, request.thresholds.error_floor}));
}

// A dataset whose estimates are `estimated_part` times the real size.
class Misjudged : public FakeSteps {
 public:
  Misjudged(double whole, double estimated_part, int& made)
      : FakeSteps(
            "misjudged",
            [whole, &made](const StepRequest& step, const std::stop_token&) {
              ++made;
              EncodedStep encoded;
              encoded.tiles.push_back({.summary = {.triangles = triangles_at(step.request, whole)},
                                       .payload = nullptr});
              return encoded;
            }),
        whole_(whole),
        part_(estimated_part) {}

  [[nodiscard]] SizeEstimates sizes(std::stop_token, SizeAccuracy) const override {
    const auto of = [this](const IsosurfaceRequest& request) {
      const double triangles = part_ * triangles_at(request, whole_);
      return SurfaceSize{.triangles = triangles, .bytes = 0, .extracted = triangles};
    };
    return {.of = [of](const StepRequest& step) { return of(step.request); }, .rough = of};
  }

 private:
  double whole_;
  double part_;
};

TEST(StreamPlan, EndsBeforeTheFinalStepIfOnlyPreviewsAreRequested) {
  const FakeSteps source("large");
  StreamState state = {.request = {.error = 1}, .steps = StepPolicy::kPreviewsOnly};
  std::size_t previews = 0;
  for (;; ++previews) {
    const auto made = make_next_step(source, state, {});
    ASSERT_TRUE(made);
    if (made->is_over) break;
    EXPECT_FALSE(made->is_final);
    state = made->after;
    state.delivered.push_back(
        {.step = made->step, .size = size_of(made->encoded), .seconds = 0.01});
    ASSERT_LT(previews, 20U);
  }
  EXPECT_GT(previews, 0U);
}

TEST(StreamPlan, MeetsABudgetWithTheSecondSurface) {
  for (const double part : {1.0, 0.9, 0.7, 0.3, 0.05}) {
    SCOPED_TRACE(part);
    int made = 0;
    const Misjudged source(1e6, part, made);
    const StreamState state = {.request = {.error = 0.25, .max_triangles = 100'000},
                               .steps = StepPolicy::kFinalOnly};
    const StepResult step = make_next_step(source, state, {}).value();
    EXPECT_TRUE(step.is_final);
    EXPECT_LE(made, 2);
    EXPECT_EQ(made == 1, part >= 0.9) << "estimates are trusted to a tenth";
    const double triangles = size_of(step.encoded).triangles;
    EXPECT_LE(triangles, 100'000);
    EXPECT_GE(triangles, 70'000) << "nothing is given away";
  }
}

TEST(StreamPlan, RebuildsFinerAfterATooLargeEstimate) {
  for (const double part : {1.5, 2.0, 5.0, 100.0}) {
    int made = 0;
    const Misjudged source(1e6, part, made);
    const StepResult step = make_next_step(source,
                                           {.request = {.error = 0.25, .max_triangles = 100'000},
                                            .steps = StepPolicy::kFinalOnly},
                                           {})
                                .value();
    EXPECT_EQ(made, 2) << part;
    EXPECT_LE(size_of(step.encoded).triangles, 100'000);
    EXPECT_GE(size_of(step.encoded).triangles, 70'000) << part;
  }
}

// The estimates do not depend on the error.
TEST(StreamPlan, MeetsABudgetWithConstantEstimates) {
  class Constant : public Misjudged {
   public:
    using Misjudged::Misjudged;
    [[nodiscard]] SizeEstimates sizes(std::stop_token, SizeAccuracy) const override {
      const auto of = [](const auto&) { return SurfaceSize{.triangles = 1e5, .extracted = 1e5}; };
      return {.of = of, .rough = of};
    }
  };
  for (const std::uint64_t budget : {20'000ULL, 90'000ULL, 120'000ULL, 700'000ULL}) {
    int made = 0;
    const Constant source(1e6, 1, made);
    const auto step = make_next_step(
        source,
        {.request = {.error = 0.25, .max_triangles = budget}, .steps = StepPolicy::kFinalOnly}, {});
    ASSERT_TRUE(step) << budget;
    EXPECT_LE(size_of(step->encoded).triangles, budget);
    EXPECT_LE(made, 10) << budget;
  }
}

// Numbers of a large smooth surface, where size samples fail: its simplified blocks are mostly
// border.
TEST(StreamPlan, UsesABudgetIfEstimatesStopDecreasing) {
  class Plateau : public Misjudged {
   public:
    using Misjudged::Misjudged;
    [[nodiscard]] SizeEstimates sizes(std::stop_token stop, SizeAccuracy accuracy) const override {
      const auto of = [real = Misjudged::sizes(stop, accuracy).of](const StepRequest& step) {
        SurfaceSize size = real(step);
        size.triangles = std::max(size.triangles, 5e5);
        return size;
      };
      return {.of = of, .rough = Misjudged::sizes(stop, accuracy).rough};
    }
  };
  int made = 0;
  const Plateau source(1e6, 1, made);
  const auto step = make_next_step(
      source,
      {.request = {.error = 0.25, .max_triangles = 100'000}, .steps = StepPolicy::kFinalOnly}, {});
  ASSERT_TRUE(step);
  EXPECT_LE(size_of(step->encoded).triangles, 100'000);
  EXPECT_GE(size_of(step->encoded).triangles, 50'000);
  EXPECT_LE(made, 6);
}

TEST(StreamPlan, RejectsOnlyStepsSurelyAboveTheTriangleLimit) {
  int made = 0;
  const auto make = [&made](double estimated_part, const IsosurfaceRequest& request) {
    made = 0;
    const Misjudged source(1e6, estimated_part, made);
    return make_next_step(source, {.request = request, .steps = StepPolicy::kFinalOnly}, {},
                          {.max_triangles = 1'200'000});
  };
  EXPECT_TRUE(make(1.5, {.error = 1})->is_final) << "estimates are up to a half too large";
  EXPECT_TRUE(make(3, {.error = 1, .simplify = true})->is_final) << "and with simplification more";
  EXPECT_EQ(make(4, {.error = 1}).error().code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(made, 0) << "at once";
  EXPECT_EQ(make(4, {.error = 1, .simplify = true}).error().code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(made, 0);
  EXPECT_TRUE(make(4, {.error = 1, .max_triangles = 500'000})->is_final);
  EXPECT_TRUE(make(4, {.error = 1, .max_bytes = 1000})->is_final) << "a budget makes it small";
}

TEST(StreamPlan, SendsACellInOneStepAtItsSpacing) {
  int made = 0;
  const Misjudged source(1e6, 1, made);
  StreamState state = {.request = {.error = 1}, .steps = StepPolicy::kProgressive};
  state.request.cell = OctreeNode{.cube = {5, 0, 0, 0}, .finest_spacing = 8};
  const StepResult step = make_next_step(source, state, {}).value();
  EXPECT_TRUE(step.is_final);
  EXPECT_EQ(step.step.request, state.request);
  EXPECT_EQ(step.step.finest_spacing, 8);
  EXPECT_EQ(made, 1);
  const auto refused = make_next_step(source, state, {}, {.max_triangles = 999'999});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
  EXPECT_FALSE(estimate(source, state.request, {}));
}

// Simplification itself stops at the budget.
TEST(StreamPlan, BuildsASimplifiedSurfaceOnceAndReportsItsThreshold) {
  int made = 0;
  const FakeSteps source("simplified", [&made](const StepRequest& step, const std::stop_token&) {
    ++made;
    EXPECT_EQ(step.request.thresholds.error_floor, 0);
    EncodedStep tiled;
    tiled.tiles.push_back({.summary = {.triangles = 95}, .payload = nullptr});
    tiled.error_floor = 2.5;
    return tiled;
  });
  StreamState state = {.request = {.error = 0.25, .max_triangles = 100, .simplify = true},
                       .steps = StepPolicy::kFinalOnly};
  const StepResult step = make_next_step(source, state, {}).value();
  EXPECT_TRUE(step.is_final);
  EXPECT_EQ(made, 1);
  EXPECT_EQ(step.step.request.thresholds.error_floor, 2.5);
  state.request.max_triangles = 94;
  const auto refused = make_next_step(source, state, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
  EXPECT_NE(refused.error().text.find("at least 95 triangles"), std::string::npos);
}

TEST(StreamPlan, RejectsABudgetThatNoSurfaceMeets) {
  int made = 0;
  const Misjudged source(1e6, 1e-4, made);
  const auto refused = make_next_step(
      source, {.request = {.error = 0.25, .max_triangles = 5}, .steps = StepPolicy::kFinalOnly},
      {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(
      refused.error().text,
      "The budget of 5 triangles is too small: with its topology kept the surface has at "
      "least 15625 triangles. Allow more, or use an isovalue with a simpler surface, or allow "
      "features of up to 1 voxels to vanish with topology_tolerance.");
  EXPECT_LE(made, 3);
  const Misjudged stubborn(1e6, 1, made);
  const auto no_tolerance = make_next_step(
      stubborn, {.request = {.error = 0.25, .max_triangles = 5}, .steps = StepPolicy::kFinalOnly},
      {});
  ASSERT_FALSE(no_tolerance);
  EXPECT_NE(no_tolerance.error().text.find("no topology_tolerance fits"), std::string::npos);
  const int made_once = made;
  const auto again = make_next_step(
      source, {.request = {.error = 0.25, .max_triangles = 6}, .steps = StepPolicy::kFinalOnly},
      {});
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().text.find("budget of 6 triangles"), std::string::npos);
  EXPECT_EQ(made, made_once) << "the size of the coarsest surface is known";
}

// A stream that continues after another server stopped.
TEST(StreamPlan, StartsWithTheResumedPreviews) {
  const FakeSteps source("head");
  for (const bool previews : {false, true}) {
    StreamState state;
    state.request.error = 0.5;
    state.request.simplify = true;
    state.steps = previews ? StepPolicy::kProgressive : StepPolicy::kFinalOnly;
    state.resumed_previews = {{.finest_spacing = 16},
                              {.finest_spacing = 4, .is_unsimplified = true}};
    for (const Preview& preview : state.resumed_previews) {
      const StepResult made = make_next_step(source, state, {}).value();
      EXPECT_FALSE(made.is_final);
      EXPECT_EQ(made.step, preview_step(state.request, preview, source.info()));
      state = made.after;
      state.delivered.push_back({.step = made.step, .size = size_of(made.encoded)});
    }
    const StepResult next = make_next_step(source, state, {}).value();
    EXPECT_LT(next.step.finest_spacing, 4);
    if (!previews) {
      EXPECT_TRUE(next.is_final) << "the final step had begun";
    }
  }
}

class LargeSteps : public FakeSteps {
 public:
  LargeSteps() : FakeSteps("large"), info_(FakeSteps::info()) {
    info_.dims = {1025, 1025, 1025};
    info_.grid_exponent = 10;
  }
  [[nodiscard]] const DatasetInfo& info() const override { return info_; }

 private:
  DatasetInfo info_;
};

// Steps named by the client have the same limits as planned ones.
TEST(StreamPlan, LimitsTrianglesOfResumedModels) {
  int made = 0;
  const Misjudged source(1'000'000, 1, made);
  const StreamState state = {.request = {.error = 0.25, .simplify = true},
                             .resumed_previews = {{.finest_spacing = 1, .is_unsimplified = true}}};
  const auto triangles = static_cast<std::uint64_t>(
      size_of(make_next_step(source, state, {}).value().encoded).triangles);
  EXPECT_TRUE(make_next_step(source, state, {}, {.max_triangles = triangles}));
  const auto refused = make_next_step(source, state, {}, {.max_triangles = triangles - 1});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLimitExceeded);
}

TEST(StreamPlan, SendsTheCertifiedPreviewOnlyWithoutWaitingWork) {
  const LargeSteps source;
  const auto has_own_model = [&](StepPolicy steps, const StepLimits& limits) {
    StreamState state = {.request = {.error = 0.5, .simplify = true}, .steps = steps};
    for (;;) {
      const StepResult made = make_next_step(source, state, {}, limits).value();
      if (made.is_final || made.is_over) return false;
      if (made.step.finest_spacing == 1) return true;
      state = made.after;
      state.delivered.push_back(
          {.step = made.step, .size = source.sizes({}, SizeAccuracy::kQuick).of(made.step)});
    }
  };
  const StepLimits alone = {.bytes_per_second = 1e9};
  EXPECT_TRUE(has_own_model(StepPolicy::kProgressive, alone));
  EXPECT_FALSE(has_own_model(StepPolicy::kPreviewsOnly, alone));
  EXPECT_FALSE(
      has_own_model(StepPolicy::kProgressive, {.bytes_per_second = 1e9, .is_contended = true}));
  EXPECT_FALSE(
      has_own_model(StepPolicy::kProgressive, {.max_triangles = 500'000, .bytes_per_second = 1e9}));
}

TEST(StreamPlan, EndsWithShellsThatTheClientCanDraw) {
  const auto ends_with_shells = [](double whole, std::uint64_t drawable_triangles,
                                   double estimated_part = 1) {
    int made = 0;
    const Misjudged source(whole, estimated_part, made);
    const StreamState state = {.request = {.error = 0.5, .simplify = true},
                               .steps = StepPolicy::kFinalOnly,
                               .shells = true,
                               .use = MeshUse::kDisplay,
                               .drawable_triangles = drawable_triangles};
    const StepLimits fast = {.bytes_per_second = 1e9};
    const StepResult last = make_next_step(source, state, {}, fast).value();
    EXPECT_TRUE(last.is_final);
    return last.step.shell.has_value();
  };
  EXPECT_TRUE(ends_with_shells(10e6, 0));
  EXPECT_FALSE(ends_with_shells(40e6, 0));
  EXPECT_TRUE(ends_with_shells(40e6, 50'000'000));
  EXPECT_FALSE(ends_with_shells(10e6, 5'000'000));
  EXPECT_FALSE(ends_with_shells(10e6, 5'000'000, 0.1)) << "the estimate is too small";
}

TEST(StreamPlan, StartsCoarserOnASlowLink) {
  const LargeSteps source;
  StreamState state;
  state.request.simplify = true;
  const auto first = [&](double bytes_per_second) {
    return make_next_step(source, state, {}, {.bytes_per_second = bytes_per_second})
        .value()
        .step.finest_spacing;
  };
  EXPECT_LT(first(1e9), first(1e3));
}

}  // namespace
}  // namespace multitetra

#include "server/core/planning/refinement_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/core/planning/budget.hpp"
#include "server/core/planning/shell_steps.hpp"
#include "server/core/planning/simplified_size.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {
namespace {

// Minimum steps a side of a preview's own grid.
constexpr std::int32_t kMinStepsPerSide = 8;
// Growth in triangles when a preview's finest spacing is halved: 3.5 to 5 on public volumes.
constexpr double kTrianglesPerHalving = 4.5;

bool is_worth_showing(std::int32_t finest, const DatasetInfo& info) {
  return (1 << info.grid_exponent) / finest >= kMinStepsPerSide;
}

struct Candidate {
  StepRequest step;
  double triangles = 0;
  double server = 0;  // Seconds.
  double link = 0;
  double client = 0;
  bool is_within_budget = true;

  [[nodiscard]] double seconds() const { return server + link + client; }
  [[nodiscard]] bool is_quick() const {
    return is_within_budget && server <= kFirstServerSeconds && link <= kFirstLinkSeconds &&
           client <= kFirstClientSeconds;
  }
  [[nodiscard]] bool is_better_than(const Candidate& other) const {
    if (is_within_budget != other.is_within_budget) return is_within_budget;
    return seconds() < other.seconds();
  }
};

Candidate candidate(const StepRequest& step, const SurfaceSize& size, const CostEstimates& costs) {
  return {.step = step,
          .triangles = size.triangles,
          .server = costs.server_seconds(size, form_of(step)),
          .link = costs.link_seconds(size),
          .client = costs.client_seconds(size),
          .is_within_budget = fits(size, step.request)};
}

// The possible steps for one request.
class Candidates {
 public:
  Candidates(const IsosurfaceRequest& request, const PlanLimits& limits, const DatasetInfo& info,
             const SizeEstimates& sizes, const CostEstimates& costs)
      : request_(request), limits_(limits), info_(info), sizes_(sizes), costs_(costs) {
    if (!limits.shells || !allows_shells(request)) return;
    certified_shells_ = multitetra::certified_shells(request, info);
    has_shells_ = true;
  }

  // Returns the step that ends the stream.
  [[nodiscard]] Candidate final_step(const DeliveredStep* delivered = nullptr) const {
    const Candidate itself = request_itself(delivered);
    if (!may_end_with_shells()) return itself;
    const Candidate shells = certified(delivered);
    const bool is_possible = shells.triangles <= limits_.shell_triangles;
    return is_possible && shells.seconds() <= itself.seconds() ? shells : itself;
  }
  [[nodiscard]] bool has_certified_shells() const { return certified_shells_.has_value(); }
  // Returns whether shells that meet the request are a final step instead of a preview.
  [[nodiscard]] bool may_end_with_shells() const {
    return limits_.is_display && certified_shells_ &&
           is_enough_to_display(*certified_shells_, request_, info_);
  }

  // Returns the request with its size from the spectrum or extrapolated from the delivered step,
  // whichever is larger: neither reads fine samples.
  [[nodiscard]] Candidate request_itself(const DeliveredStep* delivered) const {
    const StepRequest step = {.request = request_};
    SurfaceSize size = sizes_.rough(request_);
    if (delivered) {
      const double expected = growth(*delivered, 1) * delivered->size.extracted;
      if (size.extracted > 0) size.bytes *= std::max(expected / size.extracted, 1.0);
      size.extracted = std::max(size.extracted, expected);
    }
    return candidate(step, size, costs_);
  }

  // Returns the candidate with that finest spacing, with its size measured in the spectrum.
  [[nodiscard]] Candidate measured(std::int32_t finest) const {
    return quicker(finest, [this](const StepRequest& step) { return sizes_.of(step); });
  }
  // Returns the request's own model without simplification, or the full resolution in shells, with
  // its size extrapolated from the delivered step.
  [[nodiscard]] Candidate certified(const DeliveredStep* delivered) const {
    const StepRequest step =
        certified_shells_
            ? *certified_shells_
            : preview_step(request_, {.finest_spacing = 1, .is_unsimplified = true}, info_);
    const double triangles =
        delivered ? growth(*delivered, 1) * delivered->size.extracted : sizes_.of(step).extracted;
    return candidate(step,
                     {.triangles = triangles,
                      .bytes = estimated_bytes(triangles, step, info_.type),
                      .extracted = triangles},
                     costs_);
  }
  // Returns the candidate with that finest spacing, with its size extrapolated from a coarser step.
  [[nodiscard]] Candidate refined(const DeliveredStep& delivered, std::int32_t finest) const {
    const double factor = growth(delivered, finest);
    return quicker(finest, [&](const StepRequest& step) {
      const double extracted = factor * delivered.size.extracted;
      const bool was_simplified = delivered.step.request.simplify;
      const double triangles = !step.request.simplify ? extracted
                               : was_simplified       ? factor * delivered.size.triangles
                                                      : kPreviewRemainingShare * extracted;
      const bool is_alike =
          form_of(step) == form_of(delivered.step) ||
          (is_simplified(form_of(step)) && is_simplified(form_of(delivered.step)));
      const double of_estimate =
          is_alike ? delivered.size.bytes /
                         std::max(estimated_bytes(delivered.size.triangles, delivered.step), 1.0)
                   : (step.request.simplify ? kBytesOfSimplifiedTriangles : 1);
      return SurfaceSize{.triangles = triangles,
                         .bytes = of_estimate * estimated_bytes(triangles, step),
                         .extracted = extracted};
    });
  }

 private:
  [[nodiscard]] static double growth(const DeliveredStep& delivered, std::int32_t finest) {
    const double halvings = std::log2(delivered.step.finest_spacing / static_cast<double>(finest));
    return std::pow(kTrianglesPerHalving, halvings);
  }

  template <typename SizeOf>
  [[nodiscard]] Candidate quicker(std::int32_t finest, const SizeOf& size_of) const {
    if (has_shells_) {
      const StepRequest shells = preview_step(
          request_, {.finest_spacing = finest, .shell = quantized_shells(kPreviewLevels)}, info_);
      if (multitetra::has_shells(info_, level_of(shells))) {
        return candidate(shells, size_of(shells), costs_);
      }
    }
    const StepRequest plain =
        preview_step(request_, {.finest_spacing = finest, .is_unsimplified = true}, info_);
    const Candidate found = candidate(plain, size_of(plain), costs_);
    if (!request_.simplify || found.is_quick()) return found;
    const StepRequest simplified = preview_step(request_, {.finest_spacing = finest}, info_);
    const Candidate smaller = candidate(simplified, size_of(simplified), costs_);
    return smaller.is_better_than(found) ? smaller : found;
  }

  const IsosurfaceRequest& request_;
  const PlanLimits& limits_;
  const DatasetInfo& info_;
  const SizeEstimates& sizes_;
  const CostEstimates& costs_;
  bool has_shells_ = false;
  std::optional<StepRequest> certified_shells_;
};

// Returns nullopt if the final step is as fast.
std::optional<StepRequest> first_preview(const Candidates& candidates, const DatasetInfo& info,
                                         const SizeEstimates& sizes) {
  std::int32_t finest = kSpectrumSpacing;
  // Does not fetch remote data only to estimate sizes.
  while (sizes.to_fetch && is_worth_showing(2 * finest, info) &&
         sizes.to_fetch(finest) > kFirstFetchedBytes) {
    finest *= 2;
  }
  if (finest == kSpectrumSpacing && candidates.final_step().is_quick()) return std::nullopt;
  std::optional<StepRequest> coarsest;
  for (; is_worth_showing(finest, info); finest *= 2) {
    const Candidate preview = candidates.measured(finest);
    coarsest = preview.step;
    if (preview.is_quick()) break;
  }
  return coarsest;
}

double seconds_of(std::span<const DeliveredStep> delivered, const CostEstimates& costs) {
  double seconds = 0;
  for (const DeliveredStep& step : delivered) {
    seconds += step.seconds + costs.link_seconds(step.size) + costs.client_seconds(step.size);
  }
  return seconds;
}

// Returns nullopt if no preview is worth its time.
std::optional<StepRequest> further_preview(const Candidates& candidates,
                                           std::span<const DeliveredStep> delivered,
                                           const CostEstimates& costs) {
  const double before = std::max(seconds_of(delivered, costs), kFirstServerSeconds);
  const double final_seconds = candidates.final_step(&delivered.back()).seconds();
  if (final_seconds <= kShortStepSeconds) return std::nullopt;
  const double allowed = kPreviewShare * final_seconds;
  std::optional<StepRequest> best;
  for (std::int32_t finest = delivered.back().step.finest_spacing / 2; finest >= 2; finest /= 2) {
    const Candidate preview = candidates.refined(delivered.back(), finest);
    if (!preview.is_within_budget) break;
    if (preview.seconds() > std::min(best ? before : kMaxStepGrowth * before, allowed)) break;
    best = preview.step;
  }
  return best;
}

// Returns a step that meets the request's own bound before simplification does, or nullopt if that
// is not worth its time.
std::optional<StepRequest> certified_preview(const Candidates& candidates,
                                             const DeliveredStep& delivered,
                                             const PlanLimits& limits) {
  if (delivered.step.finest_spacing == 1 || candidates.may_end_with_shells()) return std::nullopt;
  const Candidate preview = candidates.certified(&delivered);
  const double allowed = kCertifiedShare * candidates.final_step(&delivered).seconds();
  const double max_triangles = preview.step.shell && limits.certified_triangles > 0
                                   ? limits.shell_triangles
                                   : limits.certified_triangles;
  const bool is_worth_it = preview.is_within_budget && preview.seconds() <= allowed &&
                           preview.triangles <= max_triangles;
  if (!is_worth_it) return std::nullopt;
  return preview.step;
}

}  // namespace

StepRequest preview_step(const IsosurfaceRequest& request, const Preview& preview,
                         const DatasetInfo& info) {
  const std::int32_t finest = preview.finest_spacing;
  const double unit = request.unit == ErrorUnit::kVoxel ? 1.0 : voxel_length(info);
  StepRequest step{.request = request, .finest_spacing = finest};
  step.request.simplify = request.simplify && !preview.is_unsimplified && !preview.shell;
  step.shell = preview.shell;
  if (finest == 1) return step;
  double& floor = step.request.thresholds.error_floor;
  floor = std::min(std::max(floor, finest / 2.0 * unit), std::numeric_limits<double>::max());
  step.request.topology_tolerance = std::max(request.topology_tolerance, finest / 2.0);
  // Coarse tetrahedra do not benefit from fine lattice steps; shells encode them for free.
  if (!preview.shell)
    step.request.lattice_resolution = std::min(request.lattice_resolution, finest >= 8 ? 3 : 4);
  return step;
}

PlannedStep next_step(const IsosurfaceRequest& request, const PlanLimits& limits,
                      std::span<const DeliveredStep> delivered, const DatasetInfo& info,
                      const SizeEstimates& sizes, const CostEstimates& costs) {
  const Candidates candidates(request, limits, info, sizes, costs);
  std::optional<StepRequest> preview;
  if (limits.previews) {
    preview = delivered.empty() ? first_preview(candidates, info, sizes)
                                : further_preview(candidates, delivered, costs);
    const bool is_simplified = request.simplify && largest_threshold(request, info) > 0;
    if (!preview && !delivered.empty() && (is_simplified || candidates.has_certified_shells())) {
      preview = certified_preview(candidates, delivered.back(), limits);
    }
  }
  if (preview) return {.step = *preview, .is_final = false};
  if (candidates.may_end_with_shells()) {
    return {.step = candidates.final_step(delivered.empty() ? nullptr : &delivered.back()).step,
            .is_final = true};
  }
  return {.step = final_step(request), .is_final = true};
}

double bits_per_vertex(const ShellStep& shell, SampleType type, int lattice_resolution) {
  const auto of_levels = [](int levels) { return 1.3 + 0.43 * std::log2(levels); };
  switch (shell.values) {
    case shell::ShellValues::kExact:
      return bytes_per_sample(type) == 1 ? 2.9 : 4.6;
    case shell::ShellValues::kLatticeExact:
      return of_levels(shell::kLatticeExactLevels) + 0.4 +
             std::max(lattice_resolution - kDefaultLatticeResolution, 0);
    case shell::ShellValues::kQuantized:
      break;
  }
  return of_levels(shell.levels_per_octave);
}

double estimated_bytes(double triangles, const StepRequest& step, SampleType type) {
  if (step.shell) {
    // There is half a vertex per triangle; coarse levels are less smooth.
    const double coarse = step.finest_spacing > 1 ? 1.4 : 1;
    const double bits = bits_per_vertex(*step.shell, type, step.request.lattice_resolution);
    return triangles * coarse * bits / 16 + kBytesPerTile;
  }
  const int normal_bits = step.request.normal_bits;
  const double normals = normal_bits == 0 ? 0 : 0.6 + 0.15 * (normal_bits - kMinNormalBits);
  const double bytes_per_triangle =
      0.3 + 0.19 * (step.request.lattice_resolution + std::log2(step.finest_spacing)) + normals;
  return triangles * bytes_per_triangle + kBytesPerTile * std::ceil(triangles / kTrianglesPerTile);
}

}  // namespace multitetra

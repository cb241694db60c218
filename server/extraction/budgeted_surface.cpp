#include "server/extraction/budgeted_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "server/core/planning/budget.hpp"
#include "server/core/planning/simplified_size.hpp"
#include "server/core/simplification/threshold_shares.hpp"
#include "server/extraction/detail/simplified_surface.hpp"
#include "server/extraction/reference_extractor.hpp"
#include "server/extraction/surface_sizes.hpp"

namespace multitetra {
namespace {

// By a quick estimate, the first surface exceeds the budget by at most this factor. If it is within
// the budget, a finer one may be so, too.
constexpr double kFirstPart = 1.5;
// Models with fewer triangles are built at once: that is faster than estimating.
constexpr double kSmall = 150'000;
constexpr double kSafetyFactor = 0.985;  // Smaller surfaces have slightly more bytes per triangle.
// The share of a byte budget at which the search stops.
constexpr double kMinUsedPart = 0.93;
constexpr int kMaxCorrections = 8;

double triangles_of(const TiledMesh& surface) {
  double sum = 0;
  for (const TileMesh& tile : surface.tiles) sum += static_cast<double>(tile.mesh.triangles.size());
  return sum;
}

class BudgetedSimplification {
 public:
  BudgetedSimplification(const SurfaceExtractor& extractor, const IsosurfaceRequest& request,
                         const std::stop_token& stop)
      : extractor_(extractor),
        request_(request),
        info_(extractor.dataset().info),
        stop_(stop),
        schedule_(request, info_) {
    const SizeEstimates sizes = surface_sizes(extractor, stop, SizeAccuracy::kQuick);
    if (sizes.rough(schedule_.at(0)).extracted > kSmall) {
      level_ = schedule_.lowest_fitting(sizes.of, 0, schedule_.last(), kFirstPart);
    }
    max_triangles_ = first_most();
    while (begin(), part() < 1 && level_ > 0) {
      level_ = finer_level({level_, part()});
    }
    first_level_ = level_;
  }

  [[nodiscard]] double max_triangles() const { return max_triangles_; }
  void set_max_triangles(double triangles) { max_triangles_ = triangles; }
  // Returns whether a surface with fewer triangles than this is possible.
  [[nodiscard]] bool can_shrink_below(double triangles) const {
    return remaining() < triangles || level_ < schedule_.last();
  }

  // Simplifies further until at most `max_triangles` triangles are left, if possible.
  void simplify_further() {
    std::optional<TriedLevel> before;
    while (remaining() > max_triangles_ && level_ < schedule_.last()) {
      const TriedLevel now = {level_, remaining() / max_triangles_};
      // The first small error removes far more than the next: from there sizes are extrapolated.
      level_ = level_ == 0 ? 1 : coarser_level(before, now, schedule_.last());
      before = now;
      simplifier_->simplify(options(), stop_);
    }
    // A coarser model leaves fewer triangles where only the topology preserves them.
    if (remaining() > max_triangles_ && first_level_ < level_) {
      first_level_ = level_;
      begin();
    }
  }
  // Returns the surface with `max_triangles` triangles, or as few as are left; the request's own if
  // it fits.
  [[nodiscard]] const TiledMesh& surface() {
    surface_.tiles = simplifier_->tiles(level_ == 0 ? 0 : static_cast<std::size_t>(max_triangles_));
    return surface_;
  }

  [[nodiscard]] BudgetedSurface take() {
    const double at_least = reached();
    return {.surface = std::move(surface_), .error_floor = at_least};
  }

 private:
  [[nodiscard]] double remaining() const { return static_cast<double>(simplifier_->triangles()); }
  [[nodiscard]] double part() const { return remaining() / max_triangles_; }
  [[nodiscard]] ResolvedStep spec() const {
    return resolved_step({.request = schedule_.at(level_)}, info_, stop_);
  }
  [[nodiscard]] SimplificationOptions options() const {
    SimplificationOptions options = spec().simplification();
    options.is_resumable = true;
    return options;
  }

  // Builds the surface of the current level.
  void begin() {
    const SimplificationOptions how = options();
    simplifier_.emplace(how.lattice_step, info_.grid_exponent);
    surface_ = extractor_.extract_model(
        spec(), stop_, [&](TileMesh tile) { simplifier_->add(std::move(tile), how, stop_); });
    simplifier_->simplify(how, stop_);
  }
  // Returns the budget in triangles; one of bytes by an estimate, until a surface is encoded.
  [[nodiscard]] double first_most() const {
    double max_triangles = std::numeric_limits<std::uint32_t>::max();
    if (request_.max_triangles > 0) {
      max_triangles = std::min(max_triangles, static_cast<double>(request_.max_triangles));
    }
    if (request_.max_bytes > 0) {
      constexpr double kMany = 1e6;
      const double bytes =
          kBytesOfSimplifiedTriangles * estimated_bytes(kMany, {.request = request_});
      max_triangles =
          std::min(max_triangles, kMany * static_cast<double>(request_.max_bytes) / bytes);
    }
    return std::max(max_triangles, 1.0);
  }

  // Returns the smallest floor that the surface meets. Where the thresholds are at the floor of the
  // first level, the model moved the surface by its share of that and simplification by at most the
  // bound; elsewhere both stay within their shares.
  [[nodiscard]] double reached() const {
    const double own = request_.thresholds.error_floor;
    if (level_ == 0) return own;
    double bound = 0;
    for (const TileMesh& tile : surface_.tiles) bound = std::max(bound, tile.simplification_bound);
    bound *= (1 + 1e-12) / (request_.unit == ErrorUnit::kVoxel ? voxel_length(info_) : 1);
    const double of_model = kModelShare * schedule_.at(first_level_).thresholds.error_floor;
    const double of_both = std::max(bound / (1 - kModelShare), bound + of_model);
    return std::clamp(of_both, own, schedule_.at(level_).thresholds.error_floor);
  }

  const SurfaceExtractor& extractor_;
  const IsosurfaceRequest& request_;
  const DatasetInfo& info_;
  const std::stop_token& stop_;
  ErrorSchedule schedule_;
  int level_ = 0;
  int first_level_ = 0;
  double max_triangles_ = 0;
  TiledMesh surface_;
  std::optional<SurfaceSimplifier> simplifier_;
};

}  // namespace

BudgetedSurface surface_within_budget(const SurfaceExtractor& extractor,
                                      const IsosurfaceRequest& request, const BytesOf& bytes_of,
                                      const std::stop_token& stop) {
  BudgetedSimplification simplification(extractor, request, stop);
  for (int corrections = 0;; ++corrections) {
    simplification.simplify_further();
    const TiledMesh& surface = simplification.surface();
    if (request.max_bytes == 0) break;
    const double triangles = triangles_of(surface);
    const double part = bytes_of(surface) / static_cast<double>(request.max_bytes);
    const bool is_enough = part >= kMinUsedPart || triangles < simplification.max_triangles() - 2;
    if (part <= 1 && (is_enough || corrections > 0)) break;
    if (corrections == kMaxCorrections || !simplification.can_shrink_below(triangles)) break;
    double max_triangles = std::floor(kSafetyFactor * triangles / part);
    if (request.max_triangles > 0) {
      max_triangles = std::min(max_triangles, static_cast<double>(request.max_triangles));
    }
    if (part <= 1 && max_triangles <= triangles) break;
    simplification.set_max_triangles(std::max(max_triangles, 1.0));
  }
  BudgetedSurface made = simplification.take();
  if (extractor.dataset().check) extractor.dataset().check();
  return made;
}

}  // namespace multitetra

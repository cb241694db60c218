#include "server/core/planning/budget.hpp"

#include <algorithm>
#include <cmath>

namespace multitetra {
namespace {

constexpr int kRungsAnOctave = 4;
constexpr int kFirstOctave = -4;  // A sixteenth of a voxel.
// Estimates are some ten percent off: what is aimed at leaves room for it.
constexpr double kBudgetMargin = 0.9;

// Rung 0 is the request itself. Then floors rise to the side of the grid; then the topology
// tolerance doubles up to it as well.
class Ladder {
 public:
  Ladder(const IsosurfaceRequest& request, const DatasetInfo& info)
      : request_(request),
        unit_(request.unit == LengthUnit::kVoxel ? 1.0 : voxel_length(info)),
        floors_(kRungsAnOctave * (info.grid_exponent - kFirstOctave) + 1),
        size_(1 + floors_ + info.grid_exponent + 1) {}

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] IsosurfaceRequest at(int rung) const {
    IsosurfaceRequest result = request_;
    if (rung == 0) return result;
    const int floor = std::min(rung, floors_);
    result.thresholds.at_least = std::max(request_.thresholds.at_least, unit_ * floor_of(floor));
    if (rung > floors_) {
      result.topology_tolerance =
          std::max(request_.topology_tolerance, std::ldexp(1.0, rung - floors_ - 1));
    }
    return result;
  }

 private:
  // Voxels. Products of exact numbers: the same bits on every machine.
  [[nodiscard]] static double floor_of(int rung) {
    constexpr double kParts[kRungsAnOctave] = {1, 1.189207115002721, 1.4142135623730951,
                                               1.681792830507429};
    const int i = rung - 1;
    return std::ldexp(kParts[i % kRungsAnOctave], kFirstOctave + i / kRungsAnOctave);
  }

  IsosurfaceRequest request_;
  double unit_;
  int floors_;
  int size_;
};

}  // namespace

bool fits(const SurfaceSize& size, const IsosurfaceRequest& request) {
  const auto within = [](double used, std::uint64_t most) {
    return most == 0 || used <= static_cast<double>(most);
  };
  return within(size.triangles, request.max_triangles) && within(size.bytes, request.max_bytes);
}

IsosurfaceRequest within_budget(const IsosurfaceRequest& request, const DatasetInfo& info,
                                const std::function<SurfaceSize(const StepRequest&)>& size_of) {
  if (!has_budget(request)) return request;
  const Ladder ladder(request, info);
  const auto fits_at = [&](int rung) {
    const SurfaceSize size = size_of({.request = ladder.at(rung)});
    return fits({.triangles = size.triangles / kBudgetMargin, .bytes = size.bytes / kBudgetMargin},
                request);
  };
  if (fits_at(0)) return request;
  int too_low = 0;
  int enough = ladder.size() - 1;
  while (enough - too_low > 1) {
    const int middle = (too_low + enough) / 2;
    (fits_at(middle) ? enough : too_low) = middle;
  }
  return ladder.at(enough);
}

IsosurfaceRequest one_rung_up(const IsosurfaceRequest& request, const DatasetInfo& info) {
  // What the request has is no lower rung: the ladder never lowers a floor or a tolerance.
  const Ladder ladder(request, info);
  for (int rung = 1; rung < ladder.size(); ++rung) {
    const IsosurfaceRequest higher = ladder.at(rung);
    if (higher != request) return higher;
  }
  return request;
}

}  // namespace multitetra

#include "server/extraction/model_cells.hpp"

#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <utility>

#include "server/core/errors/leaves.hpp"

namespace multitetra {
namespace {

std::int32_t size_of(const Tetrahedron& t) {
  std::int32_t size = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax({t.a[axis], t.b[axis], t.k[axis], t.d[axis]});
    size = std::max(size, high - low);
  }
  return size;
}

struct CellCorner {
  GridPoint at;
  float value = 0;
  bool is_pushed = false;  // Moved from the void beyond the data to the sample at `at`.
};
using CellCorners = std::array<CellCorner, 4>;

template <typename Sample>
class CellCollector {
 public:
  CellCollector(const Field& field, const SampledField<Sample>& sampled, double isovalue,
                ModelScope scope)
      : first_(field.first_sample()),
        last_(field.last_sample()),
        sampled_(sampled),
        isovalue_(isovalue),
        scope_(scope) {}

  void add(const Tetrahedron& t) {
    CellCorners corners{};
    const auto points = t.corners();
    for (std::size_t i = 0; i < 4; ++i) corners[i] = corner(points[i]);
    const auto is = [&](const auto& what) {
      return std::any_of(corners.begin(), corners.end(), what);
    };
    if (is([](const CellCorner& c) { return is_void(c.value); })) return;
    const bool is_crossed =
        is([&](const CellCorner& c) { return !c.is_pushed && is_positive(c); }) &&
        is([&](const CellCorner& c) { return !c.is_pushed && !is_positive(c); });
    const bool reaches_beyond = is([](const CellCorner& c) { return c.is_pushed; });
    if (is_crossed && reaches_beyond) return;
    if (scope_ == ModelScope::kSurface && !is_crossed) return;

    const std::int64_t volume =
        six_times_volume(corners[0].at, corners[1].at, corners[2].at, corners[3].at);
    if (volume == 0) return;  // Entirely beyond the data.
    if (volume < 0) std::swap(corners[2], corners[3]);
    if (reaches_beyond) keep_to_one_side(corners);
    result_.cells.push_back(
        {number(corners[0]), number(corners[1]), number(corners[2]), number(corners[3])});
    result_.sizes.push_back(size_of(t));
  }

  [[nodiscard]] ModelCells take() { return std::move(result_); }

 private:
  [[nodiscard]] bool is_positive(const CellCorner& c) const {
    return static_cast<double>(c.value) > isovalue_;
  }

  [[nodiscard]] CellCorner corner(GridPoint p) const {
    const GridPoint nearest = {std::clamp(p.x, first_.x, last_.x),
                               std::clamp(p.y, first_.y, last_.y),
                               std::clamp(p.z, first_.z, last_.z)};
    const float value = sampled_.at(p);
    if (!is_void(value) || p == nearest) return {.at = p, .value = value};
    return {.at = nearest, .value = sampled_.at(nearest), .is_pushed = true};
  }

  // Corners that were not pushed already agree, so one of them decides if there is any.
  void keep_to_one_side(CellCorners& corners) const {
    const auto own = std::find_if(corners.begin(), corners.end(),
                                  [](const CellCorner& c) { return !c.is_pushed; });
    const CellCorner decides = own != corners.end() ? *own : corners.front();
    for (CellCorner& c : corners) {
      if (is_positive(c) != is_positive(decides)) c.value = decides.value;
    }
  }

  // Cells share a point only if its value is on the same side of the isovalue in both.
  std::int64_t number(const CellCorner& c) {
    const std::uint64_t side = is_positive(c) ? std::uint64_t{1} << 63 : 0;
    const auto [at, is_new] =
        numbers_.try_emplace(LatticePoint{c.at.x, c.at.y, c.at.z}.key() | side,
                             static_cast<std::int64_t>(result_.points.size()));
    if (is_new) {
      result_.points.push_back(c.at);
      result_.values.push_back(c.value);
    }
    return at->second;
  }

  GridPoint first_;
  GridPoint last_;
  const SampledField<Sample>& sampled_;
  double isovalue_;
  ModelScope scope_;
  std::unordered_map<std::uint64_t, std::int64_t> numbers_;
  ModelCells result_;
};

}  // namespace

ModelCells model_cells(const Model& model, const Field& field, double isovalue, ModelScope scope) {
  return field.visit([&](const auto& sampled) {
    CellCollector collector(field, sampled, isovalue, scope);
    visit_leaves(model, field.grid(), root_cube(field.grid()),
                 [&](const Tetrahedron& t) { collector.add(t); });
    return collector.take();
  });
}

}  // namespace multitetra

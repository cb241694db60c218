#include "common/mesh/triangle_tree.hpp"

#include <algorithm>
#include <utility>

namespace multitetra {
namespace {

// Spreads the bits of a coordinate, with two zeros after each.
std::uint64_t spread(std::int32_t coordinate) {
  auto v = static_cast<std::uint64_t>(coordinate) & 0x1FFFFFU;
  v = (v | v << 32) & 0x001F00000000FFFFU;
  v = (v | v << 16) & 0x001F0000FF0000FFU;
  v = (v | v << 8) & 0x100F00F00F00F00FU;
  v = (v | v << 4) & 0x10C30C30C30C30C3U;
  return (v | v << 2) & 0x1249249249249249U;
}

// Returns the position on a Z-order curve, which visits each octree cube contiguously.
std::uint64_t along_curve(const TriangleBox& box) {
  const auto middle = [](std::int32_t a, std::int32_t b) { return a + (b - a) / 2; };
  return spread(middle(box.low.x, box.high.x)) | spread(middle(box.low.y, box.high.y)) << 1 |
         spread(middle(box.low.z, box.high.z)) << 2;
}

std::vector<std::uint32_t> ordered_along_curve(std::span<const TriangleBox> boxes) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(boxes.size());
  for (std::uint32_t t = 0; t < keys.size(); ++t) keys[t] = {along_curve(boxes[t]), t};
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
  return order;
}

constexpr std::int32_t kEmptyBoxLow = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t kEmptyBoxHigh = std::numeric_limits<std::int32_t>::min();
constexpr TriangleBox kEmptyBox = {{kEmptyBoxLow, kEmptyBoxLow, kEmptyBoxLow},
                                   {kEmptyBoxHigh, kEmptyBoxHigh, kEmptyBoxHigh}};

bool are_same(const TriangleBox& a, const TriangleBox& b) {
  return a.low == b.low && a.high == b.high;
}

}  // namespace

TriangleBox box_of(const LatticeTriangle& t) {
  return {{std::min({t[0].x, t[1].x, t[2].x}), std::min({t[0].y, t[1].y, t[2].y}),
           std::min({t[0].z, t[1].z, t[2].z})},
          {std::max({t[0].x, t[1].x, t[2].x}), std::max({t[0].y, t[1].y, t[2].y}),
           std::max({t[0].z, t[1].z, t[2].z})}};
}

TriangleBox box_around(const TriangleBox& a, const TriangleBox& b) {
  return {
      {std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
      {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}

void TriangleTree::Node::set(std::uint32_t i, const TriangleBox& box) {
  low[0][i] = box.low.x;
  low[1][i] = box.low.y;
  low[2][i] = box.low.z;
  high[0][i] = box.high.x;
  high[1][i] = box.high.y;
  high[2][i] = box.high.z;
}

TriangleBox TriangleTree::Node::box() const {
  const auto least = [](const Eight& v) { return *std::min_element(v.begin(), v.end()); };
  const auto largest = [](const Eight& v) { return *std::max_element(v.begin(), v.end()); };
  return {{least(low[0]), least(low[1]), least(low[2])},
          {largest(high[0]), largest(high[1]), largest(high[2])}};
}

TriangleTree::TriangleTree(std::span<const TriangleBox> boxes)
    : order_(ordered_along_curve(boxes)), places_(boxes.size()) {
  if (boxes.empty()) return;
  const std::size_t leaf_count = (boxes.size() + kWidth - 1) / kWidth;
  nodes_.reserve(leaf_count + leaf_count / (kWidth - 1) + kLevels);
  first_of_level_.push_back(0);
  nodes_.resize(leaf_count);
  for (std::uint32_t place = 0; place < order_.size(); ++place) {
    places_[order_[place]] = place;
    nodes_[place / kWidth].set(place % kWidth, boxes[order_[place]]);
  }
  while (nodes_.size() - first_of_level_.back() > 1) add_level();
}

void TriangleTree::add_level() {
  const std::size_t first = first_of_level_.back();
  const std::size_t count = nodes_.size() - first;
  first_of_level_.push_back(nodes_.size());
  nodes_.resize(nodes_.size() + (count + kWidth - 1) / kWidth);
  for (std::size_t i = 0; i < count; ++i) {
    nodes_[first_of_level_.back() + i / kWidth].set(static_cast<std::uint32_t>(i % kWidth),
                                                    nodes_[first + i].box());
  }
}

void TriangleTree::set(std::uint32_t triangle, const TriangleBox& box) {
  std::uint32_t at = places_[triangle];
  TriangleBox changed = box;
  for (const std::size_t first : first_of_level_) {
    Node& node = nodes_[first + at / kWidth];
    if (are_same(node.box(at % kWidth), changed)) return;
    node.set(at % kWidth, changed);
    changed = node.box();
    at /= kWidth;
  }
}

void TriangleTree::remove(std::uint32_t triangle) { set(triangle, kEmptyBox); }

}  // namespace multitetra

#include "common/mesh/box_tree.hpp"

#include <cassert>

#include "common/base/in_parallel.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxInLeaf = 4;
// Subtrees with more boxes check for a stop.
constexpr std::size_t kBetweenChecks = 1 << 14;

}  // namespace

void Box3::add(const Vec3& point) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], point[axis]);
    high[axis] = std::max(high[axis], point[axis]);
  }
}

void Box3::add(const Box3& box) {
  add(box.low);
  add(box.high);
}

BoxTree::BoxTree(std::span<const Box3> boxes, const std::stop_token& stop) {
  assert(boxes.size() < std::numeric_limits<std::uint32_t>::max());
  std::vector<Entry> entries;
  entries.reserve(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    entries.push_back({scaled(sum(boxes[i].low, boxes[i].high), 0.5), i});
  }
  nodes_.reserve(boxes.size());
  if (!boxes.empty()) build(boxes, entries, 0, stop);
  order_.reserve(entries.size());
  for (const Entry& entry : entries) order_.push_back(entry.number);
}

// Splits at the median along the longest side, so the depth is logarithmic.
void BoxTree::build(std::span<const Box3> boxes, std::span<Entry> entries, std::uint32_t first,
                    const std::stop_token& stop) {
  if (entries.size() > kBetweenChecks) throw_if_stopped(stop);
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  if (entries.size() <= kMaxInLeaf) {
    Node& leaf = nodes_[self];
    for (const Entry& entry : entries) leaf.box.add(boxes[entry.number]);
    leaf.first = first;
    leaf.count = static_cast<std::uint32_t>(entries.size());
    return;
  }
  Box3 centers;
  for (const Entry& entry : entries) centers.add(entry.center);
  const Vec3 size = difference(centers.high, centers.low);
  const auto axis =
      static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  const std::size_t half = entries.size() / 2;
  std::nth_element(
      entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(half), entries.end(),
      [axis](const Entry& a, const Entry& b) { return a.center[axis] < b.center[axis]; });
  build(boxes, entries.first(half), first, stop);
  const std::size_t second = nodes_.size();
  build(boxes, entries.subspan(half), first + static_cast<std::uint32_t>(half), stop);
  Node& node = nodes_[self];
  node.first = static_cast<std::uint32_t>(second);
  node.box = nodes_[self + 1].box;
  node.box.add(nodes_[second].box);
}

}  // namespace multitetra

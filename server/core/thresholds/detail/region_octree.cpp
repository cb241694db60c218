#include "server/core/thresholds/detail/region_octree.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace multitetra {
namespace {

constexpr std::size_t kShortList = 12;  // Lists of at most this length are not divided.
constexpr double kMinSide = 8;  // Grid steps. The region of a finest point has a side of 4 to 6.
// The maximum number of entries in all lists together.
constexpr std::size_t kMaxEntries = 1 << 20;
// The longest list that a query scans.
constexpr std::size_t kLongList = 64;

Box intersection(const Box& a, const Box& b) {
  Box both = a;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    both.low[axis] = std::max(a.low[axis], b.low[axis]);
    both.high[axis] = std::min(a.high[axis], b.high[axis]);
  }
  return both;
}

bool is_empty(const Box& box) {
  return box.low[0] > box.high[0] || box.low[1] > box.high[1] || box.low[2] > box.high[2];
}

}  // namespace

RegionOctree::RegionOctree(RegionSet regions, const Box& places, int exponent,
                           const std::function<void()>& check)
    : regions_(std::move(regions)),
      places_(places),
      side_(static_cast<double>(std::int64_t{1} << exponent)) {
  build(regions_.relevant(regions_.all(), places), check);
  propagate_bounds();
}

// Divides the largest cubes first, so that the entries are spread evenly.
void RegionOctree::build(RegionSet::List all, const std::function<void()>& check) {
  std::size_t entries = all.regions.size();
  nodes_.emplace_back();
  std::deque<Leaf> waiting;
  waiting.push_back({{.node = 0, .low = {}, .side = side_}, std::move(all)});
  while (!waiting.empty()) {
    if (check) check();
    const Leaf leaf = std::move(waiting.front());
    waiting.pop_front();
    set_bound(leaf);
    if (!is_divisible(leaf, entries)) {
      store(leaf);
      continue;
    }
    entries -= leaf.list.regions.size();
    for (Leaf& part : divide(leaf)) {
      entries += part.list.regions.size();
      waiting.push_back(std::move(part));
    }
  }
}

bool RegionOctree::is_divisible(const Leaf& leaf, std::size_t entries) const {
  const std::size_t size = leaf.list.regions.size();
  return !nodes_[leaf.cube.node].is_constant && size > kShortList && leaf.cube.side > kMinSide &&
         entries + 7 * size <= kMaxEntries;
}

std::vector<RegionOctree::Leaf> RegionOctree::divide(const Leaf& leaf) {
  const auto first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[leaf.cube.node].has_children = true;
  nodes_[leaf.cube.node].first = first;
  nodes_.resize(nodes_.size() + 8);
  std::vector<Leaf> parts;
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Cube cube = child(leaf.cube, first, octant);
    const Box box = box_of(cube);
    if (is_empty(box)) {  // Beyond the places: no query reaches it.
      nodes_[cube.node] = {.least = ThresholdBound{}.least, .is_constant = true};
    } else {
      parts.push_back({cube, regions_.relevant(leaf.list, box)});
    }
  }
  return parts;
}

void RegionOctree::store(const Leaf& leaf) {
  Node& node = nodes_[leaf.cube.node];
  node.is_constant = node.is_constant || leaf.list.regions.size() > kLongList;
  if (node.is_constant) return;
  node.first = static_cast<std::uint32_t>(lists_.size());
  node.count = static_cast<std::uint32_t>(leaf.list.regions.size());
  lists_.insert(lists_.end(), leaf.list.regions.begin(), leaf.list.regions.end());
}

// Children follow their parents in `nodes_`, so their sums are complete before their parent's.
void RegionOctree::propagate_bounds() {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (!node.has_children) continue;
    node.least = ThresholdBound{}.least;
    node.has_gap = false;
    for (std::size_t octant = 0; octant < 8; ++octant) {
      node.least = std::min(node.least, nodes_[node.first + octant].least);
      node.has_gap = node.has_gap || nodes_[node.first + octant].has_gap;
    }
  }
}

Box RegionOctree::box_of(const Cube& cube) const {
  return intersection(
      {cube.low, {cube.low[0] + cube.side, cube.low[1] + cube.side, cube.low[2] + cube.side}},
      places_);
}

RegionOctree::Cube RegionOctree::child(const Cube& cube, std::uint32_t first, unsigned octant) {
  Cube part{.node = first + octant, .low = cube.low, .side = cube.side / 2};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((octant >> axis & 1U) != 0) part.low[axis] += part.side;
  }
  return part;
}

// Sets the bound of a leaf's whole cube.
void RegionOctree::set_bound(const Leaf& leaf) {
  const RegionSet::List& list = leaf.list;
  Node& bounded = nodes_[leaf.cube.node];
  bounded.has_gap = !list.is_closed;
  bounded.least = ThresholdBound{}.least;
  double largest = 0;
  for (const RegionSet::Index i : list.regions) {
    bounded.least = std::min(bounded.least, regions_.threshold(i));
    largest = std::max(largest, regions_.threshold(i));
  }
  bounded.is_constant = list.regions.empty() || (list.is_closed && bounded.least == largest);
}

ThresholdBound RegionOctree::least_in(const Box& box) const {
  ThresholdBound bound;
  add({.node = 0, .low = {}, .side = side_}, box, bound);
  return bound;
}

void RegionOctree::add(const Cube& cube, const Box& box, ThresholdBound& bound) const {
  const Node& node = nodes_[cube.node];
  if (node.least >= bound.least && (bound.has_gap || !node.has_gap)) return;
  const Box whole = box_of(cube);
  if (node.is_constant || contains(box, whole)) {
    bound.least = std::min(bound.least, node.least);
    bound.has_gap = bound.has_gap || node.has_gap;
    return;
  }
  if (!node.has_children) {
    add_leaf(node, intersection(box, whole), bound);
    return;
  }
  // The middle belongs to the upper half. So every place belongs to one leaf, and a box inside
  // another visits no leaf that the outer one does not visit.
  unsigned lower = 0;
  unsigned upper = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = cube.low[axis] + cube.side / 2;
    if (box.low[axis] < middle) lower |= 1U << axis;
    if (box.high[axis] >= middle) upper |= 1U << axis;
  }
  for (unsigned octant = 0; octant < 8; ++octant) {
    if ((octant & ~upper) != 0 || (~octant & 7U & ~lower) != 0) continue;
    add(child(cube, node.first, octant), box, bound);
  }
}

void RegionOctree::add_leaf(const Node& node, const Box& part, ThresholdBound& bound) const {
  const RegionSet::MappedBox places = regions_.mapped(part);
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const RegionSet::Index region = lists_[i];
    const Contact contact = regions_.contact(region, places);
    if (contact == Contact::kDisjoint) continue;
    bound.least = std::min(bound.least, regions_.threshold(region));
    if (contact == Contact::kContains) return;
  }
  bound.has_gap = true;
}

}  // namespace multitetra

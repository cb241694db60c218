#include "server/core/region_octree.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace multitetra {
namespace {

constexpr std::size_t kShortList = 4;         // Not worth a division.
constexpr double kLeastSide = 4;              // Grid steps: about the region of the finest points.
constexpr std::size_t kMaxEntries = 1 << 20;  // Of all lists together.

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

// Cubes whose lists wait to be divided, the largest first.
struct RegionOctree::Growth {
  struct Entry {
    Cube cube;
    RegionSet::List list;
  };
  std::deque<Entry> waiting;
  std::size_t entries = 0;  // Of all lists, waiting or settled.
};

RegionOctree::RegionOctree(RegionSet regions, const Box& places, int exponent)
    : regions_(std::move(regions)),
      places_(places),
      side_(static_cast<double>(std::int64_t{1} << exponent)) {
  Growth growth;
  nodes_.emplace_back();
  growth.waiting.push_back(
      {{.node = 0, .low = {}, .side = side_}, regions_.relevant(regions_.all(), places)});
  growth.entries = growth.waiting.front().list.regions.size();
  while (!growth.waiting.empty()) {
    const Growth::Entry entry = std::move(growth.waiting.front());
    growth.waiting.pop_front();
    const std::size_t size = entry.list.regions.size();
    settle(entry.cube.node, entry.list);
    if (nodes_[entry.cube.node].is_constant || size <= kShortList ||
        entry.cube.side <= kLeastSide || growth.entries + 7 * size > kMaxEntries) {
      nodes_[entry.cube.node].first = static_cast<std::uint32_t>(lists_.size());
      nodes_[entry.cube.node].count = static_cast<std::uint32_t>(size);
      lists_.insert(lists_.end(), entry.list.regions.begin(), entry.list.regions.end());
      continue;
    }
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    nodes_[entry.cube.node].has_children = true;
    nodes_[entry.cube.node].first = first;
    nodes_.resize(nodes_.size() + 8);
    growth.entries -= size;
    for (unsigned octant = 0; octant < 8; ++octant) {
      const Cube part = child(entry.cube, first, octant);
      const Box box = box_of(part);
      if (is_empty(box)) {  // Beyond the places: no query comes here.
        nodes_[part.node] = {.least = SaidThreshold{}.least, .is_constant = true};
        continue;
      }
      growth.waiting.push_back({part, regions_.relevant(entry.list, box)});
      growth.entries += growth.waiting.back().list.regions.size();
    }
  }
  // Children stand behind their parents: what they say is known when a parent's turn comes.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (!node.has_children) continue;
    node.least = SaidThreshold{}.least;
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

void RegionOctree::settle(std::uint32_t node, const RegionSet::List& list) {
  Node& settled = nodes_[node];
  settled.has_gap = !list.is_closed;
  settled.least = SaidThreshold{}.least;
  double largest = 0;
  for (const RegionSet::Index i : list.regions) {
    settled.least = std::min(settled.least, regions_.threshold(i));
    largest = std::max(largest, regions_.threshold(i));
  }
  settled.is_constant = list.regions.empty() || (list.is_closed && settled.least == largest);
}

SaidThreshold RegionOctree::least_in(const Box& box) const {
  SaidThreshold said;
  add({.node = 0, .low = {}, .side = side_}, box, said);
  return said;
}

void RegionOctree::add(const Cube& cube, const Box& box, SaidThreshold& said) const {
  const Node& node = nodes_[cube.node];
  if (node.least >= said.least && (said.has_gap || !node.has_gap)) return;
  const Box whole = box_of(cube);
  if (node.is_constant || contains(box, whole)) {
    said.least = std::min(said.least, node.least);
    said.has_gap = said.has_gap || node.has_gap;
    return;
  }
  if (!node.has_children) {
    add_leaf(node, intersection(box, whole), said);
    return;
  }
  // Both halves of an axis where the box has places on either side of the middle. A box that only
  // ends at the middle has no place in the other half that this one lacks.
  unsigned lower = 0;
  unsigned upper = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = cube.low[axis] + cube.side / 2;
    if (box.low[axis] < middle || box.high[axis] <= middle) lower |= 1U << axis;
    if (box.high[axis] > middle || box.low[axis] >= middle) upper |= 1U << axis;
  }
  for (unsigned octant = 0; octant < 8; ++octant) {
    if ((octant & ~upper) != 0 || (~octant & 7U & ~lower) != 0) continue;
    add(child(cube, node.first, octant), box, said);
  }
}

void RegionOctree::add_leaf(const Node& node, const Box& part, SaidThreshold& said) const {
  const RegionSet::Places places = regions_.places(part);
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const RegionSet::Index region = lists_[i];
    const Contact contact = regions_.contact(region, places);
    if (contact == Contact::kApart) continue;
    said.least = std::min(said.least, regions_.threshold(region));
    if (contact == Contact::kContains) return;
  }
  said.has_gap = true;
}

}  // namespace multitetra

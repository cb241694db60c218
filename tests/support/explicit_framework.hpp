// The framework as Zhou, Chen and Kaufman 1997 store it: the binary tree of tetrahedra as an array
// with computed child addresses, the table of dividing points with the chains of tetrahedra they
// divide, and bottom-up fusion. It shares only the bisection scheme with core: links, rings,
// parents, errors and the model are derived from the tree. Memory is proportional to the grid's
// full resolution, so use n <= 16.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "common/request/isosurface_request.hpp"
#include "server/core/errors/leaves.hpp"
#include "server/core/errors/own_error.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra::testing {

using CornerSet = std::array<GridPoint, 4>;  // Sorted.

inline CornerSet corner_set(const Tetrahedron& t) {
  CornerSet corners = t.corners();
  std::sort(corners.begin(), corners.end());
  return corners;
}

class ExplicitFramework {
 public:
  explicit ExplicitFramework(const Field& field)
      : field_(field), depth_(3 * field.grid().exponent() - 1) {
    const std::size_t nodes_a_tree = std::size_t{2} << depth_;  // Addresses 1 .. 2^(depth + 1) - 1.
    for (const Tetrahedron& root : tetrahedra_of(root_cube(field.grid()))) {
      std::vector<Tetrahedron> tree(nodes_a_tree);
      tree[1] = root;
      for (std::size_t address = 1; 2 * address < nodes_a_tree; ++address) {
        const auto halves = tree[address].bisect();
        tree[2 * address] = halves[0];
        tree[2 * address + 1] = halves[1];
      }
      trees_.push_back(std::move(tree));
    }
    for (std::size_t tree = 0; tree < trees_.size(); ++tree) {
      for (std::size_t address = 1; 2 * address < nodes_a_tree; ++address) {
        Entry& entry = table_[midpoint(trees_[tree][address].a, trees_[tree][address].b)];
        entry.chain.push_back({tree, address});
        entry.depth = depth_of(address);
      }
    }
  }

  // Returns the number of tetrahedra that each dividing point divides.
  [[nodiscard]] std::map<GridPoint, std::size_t> chain_lengths() const {
    std::map<GridPoint, std::size_t> lengths;
    for (const auto& [point, entry] : table_) lengths[point] = entry.chain.size();
    return lengths;
  }

  // Returns the link of a point, derived from its chain.
  [[nodiscard]] std::set<GridPoint> link(GridPoint point) const {
    std::set<GridPoint> link;
    for (const Address& at : table_.at(point).chain) link.insert({node(at).k, node(at).d});
    return link;
  }

  // Returns the points that divide the halves of the tetrahedra divided by `point`.
  [[nodiscard]] std::set<GridPoint> children(GridPoint point) const {
    std::set<GridPoint> children;
    for (const Address& at : table_.at(point).chain) {
      for (const std::size_t half : {2 * at.address, 2 * at.address + 1}) {
        if (depth_of(half) < depth_) {
          const Tetrahedron& t = trees_[at.tree][half];
          children.insert(midpoint(t.a, t.b));
        }
      }
    }
    return children;
  }

  // Fuses bottom-up as far as allowed, and returns the remaining tetrahedra.
  [[nodiscard]] std::set<CornerSet> fuse(double isovalue, double threshold, ErrorMeasure measure,
                                         TopologyRule rule, double topology_tolerance) {
    std::vector<std::map<GridPoint, Entry>::iterator> by_depth;
    for (auto it = table_.begin(); it != table_.end(); ++it) by_depth.push_back(it);
    std::stable_sort(by_depth.begin(), by_depth.end(), [](const auto& a, const auto& b) {
      return a->second.depth > b->second.depth;
    });
    for (const auto& it : by_depth) {
      Entry& entry = it->second;
      const Own own = own_error_of(it->first, entry, isovalue);
      double below = 0;
      int flips_below = 0;
      bool children_are_fused = true;
      for (const GridPoint& child : children(it->first)) {
        const Entry& c = table_.at(child);
        below = std::max(below, c.error);
        flips_below = std::max(flips_below, c.flip_spacing);
        children_are_fused = children_are_fused && c.is_fused;
      }
      entry.error = measure == ErrorMeasure::kPaper ? std::max(own.displacement, below)
                                                    : own.certified + below;
      const bool forbidden = rule == TopologyRule::kPaper ? own.flip : own.critical;
      entry.flip_spacing =
          std::max(flips_below, forbidden ? static_cast<int>(spacing_of(it->first)) : 0);
      entry.is_fused = children_are_fused && entry.error <= threshold &&
                       entry.flip_spacing <= topology_tolerance;
    }
    std::set<CornerSet> leaves;
    for (std::size_t tree = 0; tree < trees_.size(); ++tree) collect_leaves({tree, 1}, leaves);
    return leaves;
  }

 private:
  struct Address {
    std::size_t tree;
    std::size_t address;
  };
  struct Entry {
    std::vector<Address> chain;
    int depth = 0;
    double error = 0;
    int flip_spacing = 0;
    bool is_fused = false;
  };
  struct Own {
    double displacement = 0;
    double certified = 0;
    bool flip = false;
    bool critical = false;
  };

  [[nodiscard]] static int depth_of(std::size_t address) {
    int depth = 0;
    while (address > 1) address /= 2, ++depth;
    return depth;
  }
  [[nodiscard]] const Tetrahedron& node(const Address& at) const {
    return trees_[at.tree][at.address];
  }
  [[nodiscard]] double value(GridPoint p) const {
    return field_.visit([&](const auto& sampled) { return static_cast<double>(sampled.at(p)); });
  }
  [[nodiscard]] double distance(GridPoint p, GridPoint q) const {
    const Vec3& spacing = field_.spacing();
    return std::hypot((p.x - q.x) * spacing[0], (p.y - q.y) * spacing[1], (p.z - q.z) * spacing[2]);
  }

  [[nodiscard]] Own own_error_of(GridPoint p, const Entry& entry, double c) const {
    const Tetrahedron& first = node(entry.chain.front());
    std::set<GridPoint> diamond = link(p);
    std::map<GridPoint, int> link_degree;
    int sign_changes = 0;
    for (const Address& at : entry.chain) {
      const Tetrahedron& t = node(at);
      ++link_degree[t.k];
      ++link_degree[t.d];
      sign_changes += (value(t.k) > c) != (value(t.d) > c) ? 1 : 0;
    }
    diamond.insert({first.a, first.b});

    bool any_void = std::isnan(value(p));
    bool positive = value(p) > c;
    bool negative = value(p) <= c;
    for (const GridPoint& x : diamond) {
      any_void = any_void || std::isnan(value(x));
      positive = positive || value(x) > c;
      negative = negative || value(x) <= c;
    }
    if (!positive || !negative) return {};
    if (any_void) return {.flip = true, .critical = true};

    const double a = value(first.a);
    const double b = value(first.b);
    const double m = value(p);
    const double v = (a + b) / 2;
    double from_m = 0;
    double from_v = 0;
    Own own;
    for (const GridPoint& x : diamond) {
      const auto crossing = [&](double y) {
        return (value(x) > c) == (y > c) ? 0.0 : (c - y) / (value(x) - y) * distance(p, x);
      };
      own.displacement = std::max(own.displacement, std::abs(crossing(m) - crossing(v)));
      from_m = std::max(from_m, crossing(m));
      from_v = std::max(from_v, crossing(v));
    }
    own.certified = (m > c) == (v > c) ? own.displacement : from_m + from_v;
    own.flip = (a > c) == (b > c) && (m > c) != (a > c);
    const bool link_is_closed =
        std::all_of(link_degree.begin(), link_degree.end(),
                    [](const auto& point_degree) { return point_degree.second == 2; });
    own.critical = own.flip && !(link_is_closed && sign_changes == 2);
    return own;
  }

  void collect_leaves(const Address& at, std::set<CornerSet>& leaves) const {
    const Tetrahedron& t = node(at);
    if (depth_of(at.address) == depth_ || table_.at(midpoint(t.a, t.b)).is_fused) {
      leaves.insert(corner_set(t));
      return;
    }
    collect_leaves({at.tree, 2 * at.address}, leaves);
    collect_leaves({at.tree, 2 * at.address + 1}, leaves);
  }

  const Field& field_;
  int depth_;  // The depth of the unit tetrahedra.
  std::vector<std::vector<Tetrahedron>> trees_;
  std::map<GridPoint, Entry> table_;
};

}  // namespace multitetra::testing

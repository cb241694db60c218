#include "server/core/carried_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace multitetra {

double CarriedMap::bound() const { return std::sqrt(squared_bound) * (1 + kRounding); }

void CarriedMap::append(const CarriedMap& other, std::span<const std::uint32_t> vertices,
                        std::uint32_t first_triangle) {
  for (std::size_t v = 0; v < other.carriers.size(); ++v) {
    if (vertices[v] >= carriers.size()) carriers.resize(vertices[v] + 1, kNone);
    if (other.carriers[v] != kNone) carriers[vertices[v]] = first_triangle + other.carriers[v];
  }
  std::uint32_t begin = 0;
  for (const Edge& edge : other.edges) {
    const auto from = crossings.size();
    for (std::uint32_t i = begin; i < edge.end; ++i) {
      crossings.push_back(4 * first_triangle + other.crossings[i]);
    }
    begin = edge.end;
    Edge added = {.low = vertices[edge.low],
                  .high = vertices[edge.high],
                  .end = static_cast<std::uint32_t>(crossings.size())};
    if (added.low > added.high) {
      std::swap(added.low, added.high);
      std::reverse(crossings.begin() + static_cast<std::ptrdiff_t>(from), crossings.end());
    }
    edges.push_back(added);
  }
  squared_bound = std::max(squared_bound, other.squared_bound);
}

}  // namespace multitetra

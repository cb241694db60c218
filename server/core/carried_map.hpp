// What is kept of a map from a surface M onto the compacted one, N, between one compaction and the
// next (see carried_surface.hpp): in numbers of M's vertices, and of N's triangles and corners as
// in collapsing_mesh.hpp. Pieces are joined by putting their maps together.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/core/collapsing_mesh.hpp"

namespace multitetra {

struct CarriedMap {
  static constexpr std::uint32_t kNone = CollapsingMesh::kNone;
  // Relative, and more than what rounding takes from a distance, to the thinnest triangles too.
  static constexpr double kRounding = 1e-6;

  // Of M, between two of its triangles. low < high.
  struct Edge {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    std::uint32_t end = 0;  // Of its crossings; they begin where those of the edge before end.
  };
  std::vector<std::uint32_t> carriers;  // Of every vertex of M; kNone: it is a vertex of N.
  std::vector<Edge> edges;
  // For every crossing, from the low end on: a corner opposite to the edge of N.
  std::vector<std::uint32_t> crossings;
  double squared_bound = 0;  // No squared distance of a pair is larger, but for rounding.

  // No distance is larger.
  [[nodiscard]] double bound() const;
  // Adds that of another piece of surface. Its vertices have the numbers `vertices` here; its
  // triangles come from `first_triangle` on. New vertices are those beyond the ones known so far.
  void append(const CarriedMap& other, std::span<const std::uint32_t> vertices,
              std::uint32_t first_triangle);
};

}  // namespace multitetra

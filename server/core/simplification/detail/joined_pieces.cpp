// Joins pieces of one surface.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "server/core/simplification/simplification.hpp"

namespace multitetra {

SimplifiedPiece SimplifiedPiece::joined(std::vector<SimplifiedPiece> pieces) {
  if (pieces.empty()) return {};
  SimplifiedPiece whole;
  whole.reserve(pieces);
  whole.mesh_.resolution = pieces.front().mesh_.resolution;
  whole.step_ = pieces.front().step_;
  whole.unit_ = pieces.front().unit_;
  whole.smallest_tried_limit_ = std::numeric_limits<double>::infinity();
  VertexNumbers shared;
  for (SimplifiedPiece& piece : pieces) whole.append(std::exchange(piece, {}), shared);
  whole.map_.carriers.resize(whole.mesh_.vertices.size(), CollapsingMesh::kNone);
  return whole;
}

// Reserves memory for all pieces: a growing vector would briefly hold its contents twice.
void SimplifiedPiece::reserve(std::span<const SimplifiedPiece> pieces) {
  std::size_t vertices = 0, triangles = 0, edges = 0, crossings = 0;
  for (const SimplifiedPiece& piece : pieces) {
    vertices += piece.mesh_.vertices.size();
    triangles += piece.mesh_.triangles.size();
    edges += piece.map_.edges.size();
    crossings += piece.map_.crossings.size();
  }
  mesh_.vertices.reserve(vertices);
  mesh_.triangles.reserve(triangles);
  parts_.reserve(triangles);
  errors_.reserve(vertices);
  quadrics_.reserve(vertices);
  map_.carriers.reserve(vertices);
  map_.edges.reserve(edges);
  map_.crossings.reserve(crossings);
}

// Carried vertices belong to no other piece.
void SimplifiedPiece::append(SimplifiedPiece piece, VertexNumbers& shared) {
  piece.errors_.resize(piece.mesh_.vertices.size(), 0.0F);
  const std::vector<Quadric> quadrics = piece.take_quadrics();
  const auto first_triangle = static_cast<std::uint32_t>(mesh_.triangles.size());
  std::vector<std::uint32_t> number(piece.mesh_.vertices.size());
  for (std::size_t v = 0; v < number.size(); ++v) {
    const LatticePoint& point = piece.mesh_.vertices[v];
    if (!piece.map_.carriers.empty() && piece.map_.carriers[v] != CollapsingMesh::kNone) {
      number[v] = static_cast<std::uint32_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(point);
    } else {
      number[v] = shared.number(point, mesh_.vertices);
    }
  }
  quadrics_.resize(mesh_.vertices.size());
  errors_.resize(mesh_.vertices.size(), 0.0F);
  for (std::size_t v = 0; v < number.size(); ++v) {
    quadrics_[number[v]].add(quadrics[v]);
    errors_[number[v]] = std::max(errors_[number[v]], piece.errors_[v]);
  }
  // Parts are in ascending order; a piece that was never simplified has one for each triangle.
  const std::uint32_t first_part = parts_.empty() ? 0 : parts_.back() + 1;
  for (std::uint32_t t = 0; t < piece.mesh_.triangles.size(); ++t) {
    const auto& [p, q, r] = piece.mesh_.triangles[t];
    mesh_.triangles.push_back({number[p], number[q], number[r]});
    parts_.push_back(first_part + (piece.parts_.empty() ? t : piece.parts_[t]));
  }
  map_.append(piece.map_, number, first_triangle);
  if (piece.history_) {
    if (!history_) history_.emplace();
    history_->append(*std::move(piece.history_));
  }
  if (!piece.parts_.empty())
    smallest_tried_limit_ = std::min(smallest_tried_limit_, piece.smallest_tried_limit_);
}

}  // namespace multitetra

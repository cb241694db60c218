#include "server/core/sampling/vertex_scalars.hpp"

#include <algorithm>
#include <cmath>

#include "server/core/sampling/sample_reader.hpp"

namespace multitetra {
VertexScalars vertex_scalars(const PreparedVolume& field, const LatticeMesh& mesh,
                             const Affine& grid_to_world) {
  const Affine to_index = composed(inverse(field.info.index_to_world), grid_to_world);
  std::vector<Vec3> places;
  places.reserve(mesh.vertices.size());
  for (const LatticePoint& vertex : mesh.vertices) {
    places.push_back(to_index(grid_coordinates(vertex, mesh.resolution)));
  }
  VertexScalars scalars;
  visit_type(field.info.type, [&]<typename Sample>(const Sample*) {
    BrickReader<Sample> reader(field);
    scalars.values.reserve(places.size());
    for (const Vec3& place : places) scalars.values.push_back(value_at(reader, field.info, place));
    const auto compare = [&](const Vec3& place, double interpolated) {
      const double deviation = std::abs(value_at(reader, field.info, place) - interpolated);
      // False for NaN.
      if (deviation > scalars.largest_deviation) scalars.largest_deviation = deviation;
    };
    const std::vector<double>& values = scalars.values;
    for (const TriangleIndices& t : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = t[i];
        const std::uint32_t b = t[(i + 1) % 3];
        // The adjacent triangle, possibly in another tile, has the edge reversed.
        if (mesh.vertices[a] > mesh.vertices[b]) continue;
        compare(scaled(sum(places[a], places[b]), 0.5), 0.5 * (values[a] + values[b]));
      }
      const Vec3 corners = sum(sum(places[t[0]], places[t[1]]), places[t[2]]);
      compare(scaled(corners, 1.0 / 3), (values[t[0]] + values[t[1]] + values[t[2]]) / 3);
    }
  });
  return scalars;
}

}  // namespace multitetra

#include "common/mesh/merged_tiles.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "common/mesh/detail/edge_uses.hpp"
#include "common/mesh/disjoint_sets.hpp"
#include "common/mesh/vertex_numbers.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// The vertices and edges a tile may share with others, and the counts of the rest.
struct TileSeam {
  // Lie on the cube's faces.
  std::vector<std::uint32_t> vertices;
  std::vector<std::array<std::uint32_t, 2>> edges;  // Directed, between `vertices`.
  // The component of each of `vertices`.
  std::vector<std::uint32_t> component_of;
  std::uint32_t components = 0;
  std::vector<std::uint32_t> number_of;  // The index in the merged mesh; kNone until assigned.
  MeshTopology interior;
};

// Returns for each tile the exponent of the smallest cube in its own, itself included.
std::vector<int> smallest_exponents(std::span<const TileInCube> tiles) {
  std::map<OctreeCube, std::size_t> tile_of;
  std::vector<int> smallest;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    tile_of.emplace(tiles[i].cube, i);
    smallest.push_back(tiles[i].cube.exponent);
  }
  for (const TileInCube& tile : tiles) {
    OctreeCube around = tile.cube;
    while (around.exponent < kMaxLatticeBits) {
      around = around.parent();
      const auto found = tile_of.find(around);
      if (found == tile_of.end()) continue;
      int& exponent = smallest[found->second];
      exponent = std::min(exponent, tile.cube.exponent);
    }
  }
  return smallest;
}

bool is_proper(const TriangleIndices& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; }

// Returns the faces of a marched box that contain the point: bit 2 axis + (0 low, 1 high).
std::uint8_t faces_of_box(const LatticePoint& p, const MarchedBox& box) {
  unsigned faces = 0;
  faces |= (p.x == box.low.x ? 1U : 0U) | (p.x == box.high.x ? 2U : 0U);
  faces |= (p.y == box.low.y ? 4U : 0U) | (p.y == box.high.y ? 8U : 0U);
  faces |= (p.z == box.low.z ? 16U : 0U) | (p.z == box.high.z ? 32U : 0U);
  return static_cast<std::uint8_t>(faces);
}

// Finds the seam's edges and counts the others by comparing the uses of every edge.
void add_compared_edges(const LatticeMesh& mesh, const std::vector<bool>& is_shared,
                        const DataBorder& border, TileSeam& seam) {
  const auto each_use = [&](const auto& use) {
    for (const TriangleIndices& t : mesh.triangles) {
      if (!is_proper(t)) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t to = t[i < 2 ? i + 1 : 0];
        if (!is_shared[t[i]] || !is_shared[to]) use(t[i], to);
      }
    }
  };
  for (const TriangleIndices& t : mesh.triangles) {
    if (!is_proper(t)) {
      ++seam.interior.degenerate_triangles;
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t to = t[i < 2 ? i + 1 : 0];
      if (is_shared[t[i]] && is_shared[to]) seam.edges.push_back({t[i], to});
    }
  }
  visit_edges(mesh.vertices.size(), each_use,
              [&](std::uint32_t lower, std::uint32_t upper, EdgeUses uses) {
                const auto is_on_border = [&] {
                  return border.contains_edge(mesh.vertices[lower], mesh.vertices[upper]);
                };
                count_edge(uses, is_on_border, seam.interior);
              });
}

// Does the same for a mesh marched in a box, examining only edges in the box's faces.
void add_marched_edges(const LatticeMesh& mesh, const MarchedBox& box,
                       const std::vector<bool>& is_shared, const DataBorder& border,
                       TileSeam& seam) {
  std::vector<std::uint8_t> faces;
  faces.reserve(mesh.vertices.size());
  for (const LatticePoint& p : mesh.vertices) faces.push_back(faces_of_box(p, box));
  std::int64_t used_once = 0;
  for (const TriangleIndices& t : mesh.triangles) {
    if ((faces[t[0]] | faces[t[1]] | faces[t[2]]) == 0) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i];
      const std::uint32_t to = t[(i + 1) % 3];
      if ((faces[from] & faces[to]) == 0) continue;
      ++used_once;
      if (is_shared[from] && is_shared[to]) {
        seam.edges.push_back({from, to});
      } else {
        const bool is_on_border = border.contains_edge(mesh.vertices[from], mesh.vertices[to]);
        ++(is_on_border ? seam.interior.border_edges : seam.interior.open_edges);
      }
    }
  }
  const auto uses = 3 * static_cast<std::int64_t>(mesh.triangles.size());
  seam.interior.edges = (uses + used_once) / 2 - static_cast<std::int64_t>(seam.edges.size());
}

void find_components(const LatticeMesh& mesh, TileSeam& seam) {
  DisjointSets connected(mesh.vertices.size());
  for (const TriangleIndices& t : mesh.triangles) {
    connected.join(t[0], t[1]);
    connected.join(t[1], t[2]);
  }
  // Components are numbered in the order of their first vertices, which are the roots.
  std::vector<std::uint32_t> number(mesh.vertices.size(), kNone);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (connected.root(v) == v) number[v] = seam.components++;
  }
  for (const std::uint32_t v : seam.vertices) {
    seam.component_of.push_back(number[connected.root(v)]);
  }
}

// `smallest` is that of the tile: all faces of cubes in its own are multiples of this size.
TileSeam seam_of(const TileInCube& tile, int smallest, int resolution, const DataBorder& border) {
  const LatticeMesh& mesh = *tile.mesh;
  TileSeam seam;
  std::vector<bool> is_shared(mesh.vertices.size());
  const std::int32_t within = (1 << (smallest + resolution)) - 1;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto& [x, y, z] = mesh.vertices[v];
    if ((x & within) != 0 && (y & within) != 0 && (z & within) != 0) continue;
    is_shared[v] = true;
    seam.vertices.push_back(v);
  }
  if (tile.marched) {
    add_marched_edges(mesh, *tile.marched, is_shared, border, seam);
  } else {
    add_compared_edges(mesh, is_shared, border, seam);
  }
  find_components(mesh, seam);
  seam.number_of.assign(mesh.vertices.size(), kNone);
  return seam;
}

std::int64_t joined_components(const std::vector<TileSeam>& seams, std::size_t shared_vertices) {
  std::size_t components = 0;
  for (const TileSeam& seam : seams) components += seam.components;
  DisjointSets connected(components);
  std::vector<std::uint32_t> first_at(shared_vertices, kNone);
  std::uint32_t before = 0;
  for (const TileSeam& seam : seams) {
    for (std::size_t i = 0; i < seam.vertices.size(); ++i) {
      std::uint32_t& first = first_at[seam.number_of[seam.vertices[i]]];
      const std::uint32_t component = before + seam.component_of[i];
      if (first == kNone) {
        first = component;
      } else {
        connected.join(first, component);
      }
    }
    before += seam.components;
  }
  return connected.count();
}

// Numbers the vertices that tiles may share, each once, and appends them to `vertices`.
void number_shared_vertices(std::span<const TileInCube> tiles, std::vector<TileSeam>& seams,
                            std::vector<LatticePoint>& vertices) {
  VertexNumbers numbers;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (const std::uint32_t v : seams[i].vertices) {
      seams[i].number_of[v] = numbers.number(tiles[i].mesh->vertices[v], vertices);
    }
  }
}

// Counts the edges between shared vertices, and the components of all tiles.
MeshTopology joined_topology(const std::vector<TileSeam>& seams,
                             const std::vector<LatticePoint>& shared_vertices,
                             const DataBorder& border) {
  MeshTopology counts;
  const auto each_use = [&seams](const auto& use) {
    for (const TileSeam& seam : seams) {
      for (const auto& [from, to] : seam.edges) use(seam.number_of[from], seam.number_of[to]);
    }
  };
  visit_edges(shared_vertices.size(), each_use,
              [&](std::uint32_t lower, std::uint32_t upper, EdgeUses uses) {
                const auto is_on_border = [&] {
                  return border.contains_edge(shared_vertices[lower], shared_vertices[upper]);
                };
                count_edge(uses, is_on_border, counts);
              });
  counts.components = joined_components(seams, shared_vertices.size());
  return counts;
}

void add_interior(const MeshTopology& interior, MeshTopology& counts) {
  counts.edges += interior.edges;
  counts.border_edges += interior.border_edges;
  counts.open_edges += interior.open_edges;
  counts.nonmanifold_edges += interior.nonmanifold_edges;
  counts.degenerate_triangles += interior.degenerate_triangles;
}

// The indices in the merged mesh from which a tile's own vertices and its triangles are stored.
struct TilePlace {
  std::size_t first_vertex = 0;
  std::size_t first_triangle = 0;
};

// Writes a tile's own vertices and its triangles. Numbers the vertices.
void copy_tile(const LatticeMesh& tile, const TilePlace& place,
               std::vector<std::uint32_t>& number_of, LatticeMesh& merged) {
  std::size_t next = place.first_vertex;
  for (std::size_t v = 0; v < tile.vertices.size(); ++v) {
    if (number_of[v] != kNone) continue;
    merged.vertices[next] = tile.vertices[v];
    number_of[v] = static_cast<std::uint32_t>(next++);
  }
  TriangleIndices* to = merged.triangles.data() + place.first_triangle;
  for (const TriangleIndices& t : tile.triangles) {
    *to++ = {number_of[t[0]], number_of[t[1]], number_of[t[2]]};
  }
}

}  // namespace

MergedTiles merged_tiles(std::span<const TileInCube> tiles, int resolution,
                         const DataBorder& border, const ForEachTile& for_each) {
  std::vector<TileSeam> seams(tiles.size());
  const std::vector<int> smallest = smallest_exponents(tiles);
  for_each(tiles.size(),
           [&](std::size_t i) { seams[i] = seam_of(tiles[i], smallest[i], resolution, border); });

  MergedTiles merged;
  LatticeMesh& mesh = merged.mesh;
  mesh.resolution = resolution;
  std::size_t triangle_count = 0;
  std::vector<TilePlace> places;
  for (const TileInCube& tile : tiles) {
    places.push_back({.first_vertex = 0, .first_triangle = triangle_count});
    triangle_count += tile.mesh->triangles.size();
  }
  MeshTopology& counts = merged.topology;
  for_each(2, [&](std::size_t task) {
    if (task == 0) {
      number_shared_vertices(tiles, seams, mesh.vertices);
      counts = joined_topology(seams, mesh.vertices, border);
    } else {
      mesh.triangles.resize(triangle_count);  // Writing so much memory takes as long.
    }
  });

  std::size_t vertex_count = mesh.vertices.size();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    places[i].first_vertex = vertex_count;
    vertex_count += tiles[i].mesh->vertices.size() - seams[i].vertices.size();
    add_interior(seams[i].interior, counts);
  }
  counts.vertices = static_cast<std::int64_t>(vertex_count);
  counts.triangles = static_cast<std::int64_t>(triangle_count);
  counts.euler_characteristic = counts.vertices - counts.edges + counts.triangles;

  mesh.vertices.resize(vertex_count);
  for_each(tiles.size(),
           [&](std::size_t i) { copy_tile(*tiles[i].mesh, places[i], seams[i].number_of, mesh); });
  return merged;
}

bool are_disjoint(std::span<const OctreeCube> cubes) {
  const std::set<OctreeCube> all(cubes.begin(), cubes.end());
  if (all.size() != cubes.size()) return false;
  return std::none_of(cubes.begin(), cubes.end(), [&](OctreeCube cube) {
    while (cube.exponent < kMaxLatticeBits) {
      cube = cube.parent();
      if (all.contains(cube)) return true;
    }
    return false;
  });
}

}  // namespace multitetra

#include "common/mesh/self_intersections.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

#include "common/base/in_parallel.hpp"
#include "common/base/on_threads.hpp"
#include "common/mesh/box_tree.hpp"
#include "common/mesh/detail/triangle_intersection.hpp"

namespace multitetra {
namespace {

MeshTriangle triangle_of(const TriangleMesh& mesh, std::size_t number) {
  const TriangleIndices& t = mesh.triangles[number];
  return {t, {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}};
}

// Calls body(0) ... body(count - 1), in portions large enough that threads seldom meet.
template <typename Body>
void in_portions(std::size_t count, const std::stop_token& stop, const Body& body) {
  constexpr std::size_t kPortion = 1024;
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  on_threads(threads, (count + kPortion - 1) / kPortion, [&](std::size_t portion) {
    throw_if_stopped(stop);
    const std::size_t end = std::min(count, (portion + 1) * kPortion);
    for (std::size_t i = portion * kPortion; i < end; ++i) body(i);
  });
}

}  // namespace

SelfIntersections self_intersections(const TriangleMesh& mesh, const std::stop_token& stop) {
  const std::size_t count = mesh.triangles.size();
  std::vector<Box3> boxes(count);
  std::vector<char> flat(count);
  in_portions(count, stop, [&](std::size_t i) {
    const MeshTriangle triangle = triangle_of(mesh, i);
    for (const Vec3& place : triangle.positions) boxes[i].add(place);
    flat[i] = is_flat(triangle.positions) ? 1 : 0;
  });
  const BoxTree tree(boxes, stop);
  std::vector<std::atomic<bool>> hit(count);
  std::atomic<std::uint64_t> pairs = 0;
  // In the order of the tree, for memory locality.
  in_portions(count, stop, [&](std::size_t place) {
    const std::uint32_t number = tree.order()[place];
    if (flat[number] != 0) return;
    const MeshTriangle triangle = triangle_of(mesh, number);
    std::uint64_t found = 0;
    tree.visit_near(boxes[number], [&](std::uint32_t other_place) {
      const std::uint32_t other = tree.order()[other_place];
      if (other_place <= place || flat[other] != 0 || !boxes[number].touches(boxes[other])) return;
      if (!intersect(triangle, triangle_of(mesh, other))) return;
      ++found;
      hit[number] = true;
      hit[other] = true;
    });
    if (found > 0) pairs += found;
  });
  SelfIntersections result{.pairs = pairs};
  for (std::size_t i = 0; i < count; ++i) {
    if (flat[i] != 0) ++result.flat_triangles;
    if (!hit[i]) continue;
    if (result.triangles++ > 0) continue;
    const MeshTriangle first = triangle_of(mesh, i);
    result.place =
        scaled(sum(sum(first.positions[0], first.positions[1]), first.positions[2]), 1.0 / 3);
  }
  return result;
}

}  // namespace multitetra

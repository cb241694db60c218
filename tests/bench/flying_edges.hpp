// The yardstick: VTK's flying edges, the fastest public isosurface of a whole volume that we know
// (W. Schroeder, R. Maynard, B. Geveci, "Flying Edges: A High-Performance Scalable Isocontouring
// Algorithm", LDAV 2015).
//
//   const FlyingEdges flying_edges(volume.dims, volume.spacing, samples_of(volume));
//   const auto surface = flying_edges.extract(500.5, /*threads=*/2);
//
// It computes positions and triangles only: no normals, no gradients, no scalars. It sees the
// samples in their own type and nothing beyond them: no value outside, no margin, no void.
//
// VTK 9.1 has headers that are no C++20, so this header and its source are C++17 and name no type
// of ours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>

#include "tests/bench/plain_mesh.hpp"

namespace multitetra {

class FlyingEdges {
 public:
  // Whether this program was built with VTK.
  [[nodiscard]] static bool is_available();
  // The version in VTK's words: "VTK 9.1.0".
  [[nodiscard]] static std::string version();

  // To the samples of a volume, x fastest, in the type they are stored in.
  using SamplePointer = std::variant<const std::uint8_t*, const std::int8_t*, const std::uint16_t*,
                                     const std::int16_t*, const float*>;
  // The samples must outlive it. Requires is_available().
  FlyingEdges(const std::array<std::int32_t, 3>& dims, const std::array<double, 3>& spacing,
              SamplePointer samples);
  ~FlyingEdges();
  FlyingEdges(const FlyingEdges&) = delete;
  FlyingEdges& operator=(const FlyingEdges&) = delete;

  struct Surface {
    std::uint64_t triangles = 0;
    std::string backend;  // What ran the threads, as VTK names it afterwards.
    // The most threads that VTK uses.
    int threads = 0;
    std::shared_ptr<const void> mesh;  // Keeps the memory.
  };
  // A copy of what was extracted, the first sample at the origin.
  [[nodiscard]] static PlainMesh mesh_of(const Surface& surface);

  // One thread is VTK's sequential backend, more are TBB's. The caller limits oneTBB as well.
  [[nodiscard]] Surface extract(double isovalue, int threads) const;

 private:
  struct Image;
  std::unique_ptr<const Image> image_;
};

}  // namespace multitetra

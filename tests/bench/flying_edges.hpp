// The baseline: VTK's flying edges, the fastest public isosurface extraction of whole volumes that
// we know (W. Schroeder, R. Maynard, B. Geveci, "Flying Edges: A High-Performance Scalable
// Isocontouring Algorithm", LDAV 2015).
//
//   const FlyingEdges flying_edges(volume.dims, volume.spacing, samples_of(volume));
//   const auto surface = flying_edges.extract(500.5, /*threads=*/2);
//
// Computes only positions and triangles: no normals, gradients or scalars. Reads the samples in
// their own type and nothing beyond them: no value outside, no margin, no void.
//
// Headers of VTK 9.1 do not compile as C++20, so this header and its source are C++17 and use no
// types of the project.
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
  // Returns whether this program was built with VTK.
  [[nodiscard]] static bool is_available();
  // Returns VTK's version, such as "VTK 9.1.0".
  [[nodiscard]] static std::string version();

  // Points to the samples of a volume, x fastest, in their stored type.
  using SamplePointer = std::variant<const std::uint8_t*, const std::int8_t*, const std::uint16_t*,
                                     const std::int16_t*, const float*>;
  // The samples must outlive this object. Requires is_available().
  FlyingEdges(const std::array<std::int32_t, 3>& dims, const std::array<double, 3>& spacing,
              SamplePointer samples);
  ~FlyingEdges();
  FlyingEdges(const FlyingEdges&) = delete;
  FlyingEdges& operator=(const FlyingEdges&) = delete;

  struct Surface {
    std::uint64_t triangles = 0;
    std::string backend;  // The threading backend that VTK reports afterwards.
    // The most threads used by VTK.
    int threads = 0;
    std::shared_ptr<const void> mesh;  // Owns the memory.
  };
  // Returns a copy of the surface, with the first sample at the origin.
  [[nodiscard]] static PlainMesh mesh_of(const Surface& surface);

  // Uses VTK's sequential backend for one thread, otherwise TBB's. Callers must also limit oneTBB.
  [[nodiscard]] Surface extract(double isovalue, int threads) const;

 private:
  struct Image;
  std::unique_ptr<const Image> image_;
};

}  // namespace multitetra

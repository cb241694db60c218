// Another baseline: OpenVDB's adaptive meshes (volumeToMesh), which merge flat parts of a dual
// contouring. Optional; this header and its source are C++17 and use no types of the project.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/plain_mesh.hpp"

namespace multitetra {

class OpenVdbVolume {
 public:
  [[nodiscard]] static bool is_available();
  [[nodiscard]] static std::string version();  // "OpenVDB 10.0.1"

  // `samples`: x fastest; copied. Requires is_available().
  OpenVdbVolume(const std::array<std::int32_t, 3>& dims, const std::vector<float>& samples);
  ~OpenVdbVolume();
  OpenVdbVolume(const OpenVdbVolume&) = delete;
  OpenVdbVolume& operator=(const OpenVdbVolume&) = delete;

  // Returns a mesh in sample indices, with quads split in two. `adaptivity`: 0 (none) to 1. Uses
  // all threads of oneTBB.
  [[nodiscard]] PlainMesh mesh(double isovalue, double adaptivity) const;

 private:
  struct Grid;
  std::unique_ptr<const Grid> grid_;
};

}  // namespace multitetra

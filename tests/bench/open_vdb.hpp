// Another yardstick: OpenVDB's adaptive meshes (volumeToMesh), which join flat parts of a dual
// contouring. Optional; this header and its source are C++17 and name no type of ours.
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

  // `samples`: x fastest. A copy as OpenVDB keeps it is made. Requires is_available().
  OpenVdbVolume(const std::array<std::int32_t, 3>& dims, const std::vector<float>& samples);
  ~OpenVdbVolume();
  OpenVdbVolume(const OpenVdbVolume&) = delete;
  OpenVdbVolume& operator=(const OpenVdbVolume&) = delete;

  // In sample indices, quads cut in two. `adaptivity`: 0 (none) to 1. As many threads as oneTBB
  // has.
  [[nodiscard]] PlainMesh mesh(double isovalue, double adaptivity) const;

 private:
  struct Grid;
  std::unique_ptr<const Grid> grid_;
};

}  // namespace multitetra

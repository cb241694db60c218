#include "tests/bench/open_vdb.hpp"

#ifdef MULTITETRA_HAS_OPENVDB

#include <algorithm>

#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/VolumeToMesh.h>

namespace multitetra {

struct OpenVdbVolume::Grid {
  openvdb::FloatGrid::Ptr values;
};

bool OpenVdbVolume::is_available() { return true; }

std::string OpenVdbVolume::version() {
  return std::string("OpenVDB ") + openvdb::getLibraryVersionString();
}

OpenVdbVolume::OpenVdbVolume(const std::array<std::int32_t, 3>& dims,
                             const std::vector<float>& samples) {
  openvdb::initialize();
  // Values around the data are below all samples; every sample is active, including the least.
  const float least = *std::min_element(samples.begin(), samples.end());
  auto grid = std::make_unique<Grid>();
  grid->values = openvdb::FloatGrid::create(least - 1);
  const openvdb::CoordBBox box({0, 0, 0}, {dims[0] - 1, dims[1] - 1, dims[2] - 1});
  using Dense = openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ>;
  openvdb::tools::copyFromDense(Dense(box, samples.data()), *grid->values, 0.0F);
  grid_ = std::move(grid);
}

OpenVdbVolume::~OpenVdbVolume() = default;

PlainMesh OpenVdbVolume::mesh(double isovalue, double adaptivity) const {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(*grid_->values, points, triangles, quads, isovalue, adaptivity);
  PlainMesh mesh;
  for (const auto& p : points) mesh.positions.push_back({p.x(), p.y(), p.z()});
  for (const auto& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return mesh;
}

}  // namespace multitetra

#else

#include <stdexcept>

namespace multitetra {

struct OpenVdbVolume::Grid {};

bool OpenVdbVolume::is_available() { return false; }

std::string OpenVdbVolume::version() { return "no OpenVDB"; }

OpenVdbVolume::OpenVdbVolume(const std::array<std::int32_t, 3>&, const std::vector<float>&) {
  throw std::logic_error("This program was built without OpenVDB.");
}

OpenVdbVolume::~OpenVdbVolume() = default;

PlainMesh OpenVdbVolume::mesh(double, double) const { return {}; }

}  // namespace multitetra

#endif

// A mesh file holds the surface that was checked, wherever it lies in the world.
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/mesh/self_intersections.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/scene_file.hpp"
#include "common/wire/surface_file.hpp"
#include "common/wire/written_mesh.hpp"
#include "server/certify/mesh_file.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/triangle_meshes.hpp"

namespace multitetra {
namespace {

struct Placement {
  const char* name;
  Affine grid_to_world;
  bool fits_in_floats;
  bool fits_in_draco;  // Which has one step for all axes, and rounds three times.
};

Affine scaled_to(const Vec3& spacing, const Vec3& origin) {
  return {.columns = {Vec3{spacing[0], 0, 0}, Vec3{0, spacing[1], 0}, Vec3{0, 0, spacing[2]}},
          .translation = origin};
}

// Turned about two axes, so that no axis of the grid is one of the world.
Affine turned(double step, const Vec3& origin) {
  const double c = std::cos(0.4) * step;
  const double s = std::sin(0.4) * step;
  return {.columns = {Vec3{c, s, 0}, Vec3{-s * 0.8, c * 0.8, 0.6 * step},
                      Vec3{s * 0.6, -c * 0.6, 0.8 * step}},
          .translation = origin};
}

const std::vector<Placement>& placements() {
  static const std::vector<Placement> all = {
      {"samples", {}, true, true},
      {"head", scaled_to({0.45, 0.45, 0.6}, {-112.5, -130, 40}), true, true},
      {"utm", scaled_to({0.5, 0.5, 0.5}, {500000, 5400000, 120}), false, false},
      {"earth_centered", turned(0.5, {4075539.9, 931735.3, 4801629.4}), false, false},
      {"stage_mm", scaled_to({0.0005, 0.0005, 0.0005}, {50, 20, 3}), false, false},
      {"anisotropic", scaled_to({0.001, 1, 1000}, {0, 0, 0}), true, false},
      {"anisotropic_far", scaled_to({0.001, 1, 1000}, {100, 1e6, -1e6}), false, false},
      {"mirrored", scaled_to({-0.7, 0.7, 1.3}, {100, -100, 20}), true, true},
      {"mirrored_far", scaled_to({1, 1, -1}, {-3e6, 2e6, 1e7}), false, false},
      {"sheared",
       {.columns = {Vec3{1, 0, 0}, Vec3{0.6, 1, 0}, Vec3{0.3, -0.4, 0.9}}, .translation = {}},
       true,
       true},
      {"nanometres", scaled_to({4e-9, 4e-9, 4e-8}, {1e-5, -2e-5, 3e-5}), true, false},
      {"astronomical", turned(3e19, {-4e20, 8e25, 1e24}), false, false}};
  return all;
}

class WrittenFile : public ::testing::TestWithParam<double> {
 protected:
  static DatasetPtr dataset() {
    static const DatasetPtr made =
        make_dataset(testing::fields::gyroid(13, 0.4, 5), "gyroid", -10.0, 1);
    return made;
  }
  [[nodiscard]] static LatticeMesh surface() {
    const IsosurfaceRequest request{.isovalue = 0.1,
                                    .error = GetParam(),
                                    .simplify = GetParam() > 0,
                                    .intersection_free = GetParam() > 0};
    const TiledMesh tiles = SurfaceExtractor(dataset()).extract({.request = request});
    return in_canonical_order(weld(tiles.tiles, request.lattice_resolution));
  }

  TemporaryFolder folder_;
};

// Of all formats, as a reader that knows nothing of the writers finds it.
TEST_P(WrittenFile, HasTheTopologyOfItsReportInEveryPlace) {
  const LatticeMesh lattice = surface();
  const auto anywhere = [](auto, auto) { return true; };
  const MeshTopology expected = topology(lattice.vertices.size(), lattice.triangles, anywhere);
  ASSERT_GT(expected.triangles, 300);
  ASSERT_EQ(expected.border_edges, 0);
  const bool is_simplified = GetParam() > 0;
  int written = 0;
  for (const Placement& placement : placements()) {
    const PositionedMesh mesh = positioned(lattice, placement.grid_to_world);
    for (const auto& [name, format, codec] :
         {std::tuple("a.ply", MeshFormat::kPly, MeshCodec::kNone),
          {"a.obj", MeshFormat::kObj, MeshCodec::kNone},
          {"a.vtp", MeshFormat::kVtp, MeshCodec::kNone},
          {"a.3mf", MeshFormat::k3mf, MeshCodec::kNone},
          {"a.glb", MeshFormat::kGlb, MeshCodec::kNone},
          {"packed.glb", MeshFormat::kGlb, MeshCodec::kMeshopt},
          {"a.stl", MeshFormat::kStl, MeshCodec::kNone},
          {"a.drc", MeshFormat::kDrc, MeshCodec::kNone}}) {
      SCOPED_TRACE(std::string(placement.name) + " " + name);
      const bool has_floats_only = format == MeshFormat::kStl || format == MeshFormat::kDrc;
      std::string bytes;
      try {
        bytes = mesh_file(mesh, format, {.codec = codec});
      } catch (const MeshCoordinatesError&) {
        EXPECT_FALSE(format == MeshFormat::kDrc ? placement.fits_in_draco
                                                : placement.fits_in_floats);
        EXPECT_TRUE(has_floats_only);
        continue;
      }
      EXPECT_TRUE(format != MeshFormat::kDrc || placement.fits_in_draco);
      EXPECT_TRUE(format != MeshFormat::kStl || placement.fits_in_floats);
      ++written;
      const WeldedMesh read = welded(read_mesh(folder_.file(name, bytes)));
      EXPECT_EQ(topology(read.mesh.vertices.size(), read.mesh.triangles, anywhere), expected);
      EXPECT_EQ(read.degenerate_triangles, 0U);
      const WrittenMesh reported =
          read_back(bytes, format,
                    is_simplified ? ReadBack::kSelfIntersections : ReadBack::kTopology)
              .front();
      EXPECT_EQ(reported.topology, expected);
      EXPECT_TRUE(reported.is_closed());
      EXPECT_NO_THROW(require_same(reported, mesh));
      if (!is_simplified) continue;  // Only simplification can cause intersections.
      const SelfIntersections crossing = self_intersections(read.mesh);
      EXPECT_EQ(reported.self_intersections->triangles, crossing.triangles);
      EXPECT_EQ(reported.self_intersections->flat_triangles, crossing.flat_triangles);
      if (codec == MeshCodec::kNone) {
        EXPECT_EQ(crossing.triangles, 0U);
        EXPECT_EQ(crossing.flat_triangles, 0U);
      }
    }
  }
  EXPECT_GE(written, 12 * 5 + 2 * 5);
}

// No file moves a vertex by more than a hundredth of a lattice step.
TEST_P(WrittenFile, HasItsVerticesOnTheLattice) {
  const LatticeMesh lattice = surface();
  for (const Placement& placement : placements()) {
    const PositionedMesh mesh = positioned(lattice, placement.grid_to_world);
    const Affine to_grid = inverse(placement.grid_to_world);
    for (const auto& [name, format] : {std::pair("a.ply", MeshFormat::kPly),
                                       {"a.obj", MeshFormat::kObj},
                                       {"a.vtp", MeshFormat::kVtp},
                                       {"a.3mf", MeshFormat::k3mf},
                                       {"a.glb", MeshFormat::kGlb}}) {
      SCOPED_TRACE(std::string(placement.name) + " " + name);
      const TriangleMesh read = read_mesh(folder_.file(name, mesh_file(mesh, format)));
      ASSERT_EQ(read.vertices.size(), lattice.vertices.size());
      double farthest = 0;
      for (std::size_t i = 0; i < read.vertices.size(); ++i) {
        const Vec3 off = difference(read.vertices[i], mesh.positions[i]);
        const Vec3 moved = difference(to_grid(off), to_grid(Vec3{0, 0, 0}));
        for (const double part : moved) farthest = std::max(farthest, std::abs(part));
      }
      EXPECT_LE(std::ldexp(farthest, lattice.resolution), kMaxVertexRounding);
      EXPECT_EQ(read.triangles, mesh.triangles);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, WrittenFile, ::testing::Values(0.0, 0.25, 1.0));

TEST(WrittenFile, StlNamesAShiftThatHelps) {
  const LatticeMesh lattice = surfaces::torus(5, 12, 8, 0.2, 1);
  const Affine utm = scaled_to({0.5, 0.5, 0.5}, {500000, 5400000, 120});
  try {
    (void)mesh_file(positioned(lattice, utm), MeshFormat::kStl);
    FAIL();
  } catch (const MeshCoordinatesError& error) {
    EXPECT_EQ(error.shift, "-500000,-5400000,-160");
    EXPECT_NE(std::string(error.what()).find("STL files have 32-bit coordinates"),
              std::string::npos);
  }
  Affine shifted = utm;
  shifted.translation = {0, 0, -40};
  EXPECT_NO_THROW((void)mesh_file(positioned(lattice, shifted), MeshFormat::kStl));
}

TEST(WrittenFile, ASceneReportsEachSurface) {
  const LatticeMesh lattice = surfaces::torus(5, 12, 8, 0.2, 1);
  const PositionedMesh torus = positioned(lattice, {});
  PositionedMesh open = positioned(lattice, scaled_to({1, 1, 1}, {5e6, 0, 0}));
  open.triangles.pop_back();
  const ScenePart parts[] = {{.mesh = &open}, {.mesh = &torus}};
  const auto found = read_back(scene_glb(parts), MeshFormat::kGlb);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].topology.border_edges, 3);
  EXPECT_TRUE(found[1].is_closed());
  EXPECT_EQ(found[1].topology.euler_characteristic, 0);
  EXPECT_NO_THROW(require_same(found[1], torus));
  EXPECT_THROW(require_same(found[0], torus), std::logic_error);
}

TEST(SurfaceFile, RefusesBytesThatDoNotHoldTheSurface) {
  OutputSurface torus{.mesh = positioned(surfaces::torus(5, 12, 8, 0.2, 1), {})};
  const NamedSurface named = {.surface = &torus};
  for (const MeshFormat format : {MeshFormat::kPly, MeshFormat::kStl, MeshFormat::kGlb}) {
    EXPECT_TRUE(surface_file({&named, 1}, format, MeshCodec::kNone).written.front().is_closed());
  }
  // A cut in the mesh that files do not have, as its vertices lie on equal places.
  torus.mesh.triangles.back()[0] = static_cast<std::uint32_t>(torus.mesh.positions.size());
  torus.mesh.positions.push_back(torus.mesh.positions[torus.mesh.triangles.front()[0]]);
  torus.mesh.triangles.front()[0] = torus.mesh.triangles.back()[0];
  for (const MeshFormat format : {MeshFormat::kPly, MeshFormat::kStl, MeshFormat::kGlb}) {
    for (const ReadBack counted : {ReadBack::kElements, ReadBack::kTopology}) {
      EXPECT_THROW((void)surface_file({&named, 1}, format, MeshCodec::kNone, counted),
                   std::logic_error);
    }
    // Any mesh may be saved that a file holds as well as welding does.
    const WrittenMesh written = read_back(mesh_file(torus.mesh, format), format).front();
    EXPECT_NO_THROW(require_same(written, welded_topology(torus.mesh)));
    MeshTopology other = welded_topology(torus.mesh);
    ++other.triangles;
    EXPECT_THROW(require_same(written, other), std::logic_error);
  }
}

}  // namespace
}  // namespace multitetra

// The server's own surfaces fulfil their certificates; wrong surfaces do not.
#include "server/certify/certificate.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/certify/certificate_report.hpp"
#include "server/certify/detail/closed_components.hpp"
#include "server/certify/detail/missing_components.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/prepared_fields.hpp"
#include "tests/support/triangle_meshes.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;
using testing::extracted;
using testing::PreparedSetting;

// With fewer points for the mean than users get, on which no verdict depends.
Certificate certified_against(const Volume& volume, const TriangleMesh& mesh,
                              CertifyOptions options) {
  options.samples = 2000;
  return certify(mesh, volume, options);
}

// ---- the server's surfaces

class CertificateEverySurface : public ::testing::TestWithParam<PreparedSetting> {};

TEST_P(CertificateEverySurface, AcceptsEveryExtractedSurface) {
  const PreparedSetting& setting = GetParam();
  const DatasetPtr dataset = testing::prepared(setting);
  const auto all = testing::isovalues_of(*dataset);
  // One isovalue in the middle of the range, one at an edge of the spectrum's bins.
  for (const bool is_middle : {true, false}) {
    const double isovalue = is_middle ? all[1] : all.back();
    for (const auto& [error, lattice, simplify] :
         {std::tuple(0.0, 5, false), {0.25, 5, true}, {0.5, 2, false}, {1.0, 5, true}}) {
      if (!is_middle && lattice == 5 && error < 1) continue;
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error);
      const TriangleMesh mesh = extracted(dataset, {.isovalue = isovalue,
                                                    .error = error,
                                                    .lattice_resolution = lattice,
                                                    .simplify = simplify});
      const CertifyOptions options{.isovalue = isovalue,
                                   .error = error * voxel_length(dataset->info),
                                   .lattice = lattice,
                                   .outside = setting.outside,
                                   .margin = setting.margin};
      const Certificate certificate = certified_against(setting.volume, mesh, options);
      EXPECT_TRUE(certificate.passes())
          << text_of(certificate, {.mesh = "mesh", .volume = "volume"}, options);
      EXPECT_TRUE(certificate.keeps_topology());
      EXPECT_EQ(certificate.grid.grid_exponent, dataset->info.grid_exponent);
    }
  }
}

std::string setting_name(const ::testing::TestParamInfo<PreparedSetting>& parameter) {
  return parameter.param.name;
}
INSTANTIATE_TEST_SUITE_P(All, CertificateEverySurface,
                         ::testing::ValuesIn(testing::prepared_settings()), setting_name);
INSTANTIATE_TEST_SUITE_P(WithoutErrors, CertificateEverySurface, ::testing::ValuesIn([] {
                           std::vector<PreparedSetting> some = testing::settings_without_errors();
                           some.erase(some.begin() + 2, some.end());
                           return some;
                         }()),
                         setting_name);

// ---- wrong surfaces

class CertificateErrors : public ::testing::Test {
 protected:
  [[nodiscard]] Certificate certified(const TriangleMesh& mesh, CertifyOptions options) const {
    options.isovalue = 0.1;
    return certified_against(volume_, mesh, options);
  }
  [[nodiscard]] TriangleMesh surface(double error) const {
    return extracted(dataset_, {.isovalue = 0.1, .error = error});
  }

  Volume volume_ = fields::gyroid(25, 0.1, 3);
  DatasetPtr dataset_ = make_dataset(volume_, "gyroid");
  CertifyOptions half_ = {.error = 0.5, .lattice = 5};
};

TEST_F(CertificateErrors, AcceptsTheCorrectSurface) {
  const Certificate certificate = certified(surface(0.5), half_);
  EXPECT_TRUE(certificate.passes());
  EXPECT_EQ(certificate.error, ErrorVerdict::kProven);
  EXPECT_GT(certificate.mesh.border_edges, 0);
  EXPECT_FALSE(certificate.is_watertight()) << "it ends at the border of the data";
}

TEST_F(CertificateErrors, DetectsAShift) {
  const Certificate certificate = certified(testing::shifted(surface(0.5), {1, 0, 0}), half_);
  EXPECT_EQ(certificate.error, ErrorVerdict::kExceeded);
  EXPECT_FALSE(certificate.passes());
}

TEST_F(CertificateErrors, DetectsAHole) {
  TriangleMesh mesh = surface(0);
  std::erase_if(mesh.triangles, [&](const TriangleIndices& t) {
    return length(difference(mesh.vertices[t[0]], {12, 12, 12})) < 5;
  });
  const Certificate certificate = certified(mesh, {.error = 0, .lattice = 5});
  EXPECT_LE(certificate.distance.mesh_to_reference.maximum_at_most, 0.06);
  EXPECT_GT(certificate.distance.reference_to_mesh.maximum, 1);
  EXPECT_GT(certificate.mesh.open_edges, 0);
  EXPECT_FALSE(certificate.passes());
}

TEST_F(CertificateErrors, CountsEdgesOutsideTheDataAsOpen) {
  const Certificate certificate = certified(testing::shifted(surface(0), {-100, 0, 0}), {});
  EXPECT_EQ(certificate.mesh.border_edges + certificate.mesh.open_edges,
            certificate.reference.border_edges);
  EXPECT_GT(certificate.mesh.open_edges, 0);
  EXPECT_FALSE(certificate.passes());
}

TEST_F(CertificateErrors, DetectsALargerError) {
  EXPECT_EQ(certified(surface(4), {.error = 0.05, .lattice = 5}).error, ErrorVerdict::kExceeded);
}

TEST_F(CertificateErrors, DetectsAnEmptySurface) {
  const Certificate certificate = certified({}, half_);
  EXPECT_EQ(certificate.error, ErrorVerdict::kExceeded);
  EXPECT_TRUE(std::isinf(certificate.maximum()));
  const auto json = json_of(certificate, {}, half_);
  EXPECT_TRUE(json["distances"]["full_to_mesh"]["world"]["maximum"].is_null());
}

TEST_F(CertificateErrors, MeasuresWithoutABound) {
  const TriangleMesh mesh = testing::shifted(surface(0), {0.3, 0, 0});
  const Certificate certificate = certified(mesh, {});
  EXPECT_EQ(certificate.error, ErrorVerdict::kNotRequested);
  EXPECT_GT(certificate.maximum(), 0.2);
  // Shifted off the data's border, the mesh has open edges.
  EXPECT_FALSE(certificate.passes());
  EXPECT_TRUE(certified(mesh, {.any_topology = true}).passes());
}

TEST_F(CertificateErrors, DetectsFlippedOrMissingTriangles) {
  TriangleMesh mesh = surface(0);
  const auto inside =
      std::find_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const TriangleIndices& t) {
        return length(difference(mesh.vertices[t[0]], {12, 12, 12})) < 6;
      });
  ASSERT_NE(inside, mesh.triangles.end());
  std::swap((*inside)[1], (*inside)[2]);
  EXPECT_EQ(certified(mesh, {}).mesh.nonmanifold_edges, 3);
  EXPECT_FALSE(certified(mesh, {}).passes());
  mesh.triangles.erase(inside);
  EXPECT_EQ(certified(mesh, {}).mesh.open_edges, 3);
  EXPECT_FALSE(certified(mesh, {}).passes());
}

TEST_F(CertificateErrors, SuggestsTheDatasetWhenVerticesLieBeyondTheSamples) {
  const DatasetPtr closed = make_dataset(volume_, "closed", -10, 1);
  const TriangleMesh mesh = extracted(closed, {.isovalue = 0.1, .error = 0.5});
  const auto report = [&](const CertifyOptions& options) {
    return text_of(certified(mesh, options), {.mesh = "mesh", .volume = "volume"}, options);
  };
  EXPECT_NE(report(half_).find("--volume DATASET.mtd"), std::string::npos) << report(half_);
  CertifyOptions same = half_;
  same.outside = -10;
  same.margin = 1;
  EXPECT_TRUE(certified(mesh, same).passes());
  EXPECT_EQ(report(same).find("DATASET.mtd"), std::string::npos) << report(same);
}

// ---- inside a box

// A mesh that is precise in a corner only, as with a region of a smaller error.
TEST_F(CertificateErrors, ComparesInsideABoxOnly) {
  const BoxShape corner{.low = {4, 4, 4}, .high = {11, 12, 13}};
  IsosurfaceRequest request{.isovalue = 0.1, .error = 4};
  request.thresholds.coordinates = CoordinateSystem::kIndex;
  request.thresholds.regions = {{.shape = corner, .threshold = 0.25}};
  const TriangleMesh mesh = extracted(dataset_, request);
  CertifyOptions options{.error = 0.25, .lattice = 5};
  EXPECT_EQ(certified(mesh, options).error, ErrorVerdict::kExceeded);
  options.within = PlacedBox{.box = corner};
  EXPECT_EQ(certified(mesh, options).error, ErrorVerdict::kProven);
  EXPECT_TRUE(certified(mesh, options).passes());
  options.within->box.high = {20, 20, 20};
  EXPECT_EQ(certified(mesh, options).error, ErrorVerdict::kExceeded);
}

TEST_F(CertificateErrors, CutsTheFullSurfaceAtTheBoxOfACutMesh) {
  const PlacedBox box{.box = {.low = {4.3, 4, 4}, .high = {14, 15.2, 13}}};
  const TriangleMesh mesh = clipped(surface(0), box);
  CertifyOptions options{.error = 0.1, .lattice = 5};
  EXPECT_EQ(certified(mesh, options).error, ErrorVerdict::kExceeded);
  options.within = box;
  const Certificate certificate = certified(mesh, options);
  EXPECT_TRUE(certificate.passes());
  EXPECT_LT(certificate.maximum_at_most(), 0.2);
  const auto json = json_of(certificate, {}, options);
  EXPECT_EQ(json["box"], nlohmann::ordered_json({{4.3, 4.0, 4.0}, {14.0, 15.2, 13.0}}));
  // A hole inside the box is found.
  TriangleMesh torn = mesh;
  torn.triangles.resize(torn.triangles.size() / 2);
  EXPECT_EQ(certified(torn, options).error, ErrorVerdict::kExceeded);
}

TEST_F(CertificateErrors, RefusesABoxWithoutASurface) {
  CertifyOptions options = half_;
  options.within = PlacedBox{.box = {.low = {100, 100, 100}, .high = {200, 200, 200}}};
  EXPECT_THROW((void)certified(surface(0.5), options), std::invalid_argument);
}

TEST(ClippedMesh, HasTheAreaInsideTheBox) {
  // A square of side 10, whose middle is in a turned and scaled box.
  const TriangleMesh square{.vertices = {{0, 0, 5}, {10, 0, 5}, {10, 10, 5}, {0, 10, 5}},
                            .triangles = {{0, 1, 2}, {0, 2, 3}}};
  const Affine turned{.columns = {Vec3{0, 2, 0}, {2, 0, 0}, {0, 0, 2}}, .translation = {0, 0, 0}};
  const TriangleMesh part =
      clipped(square, {.box = {.low = {4, 6, 0}, .high = {16, 12, 20}}, .world_to_box = turned});
  double area = 0;
  for (const SurfaceTriangle& t : triangles_of(part)) {
    area += length(cross(difference(t[1], t[0]), difference(t[2], t[0]))) / 2;
  }
  EXPECT_NEAR(area, 3 * 6, 1e-9);
  for (const Vec3& vertex : part.vertices) {
    EXPECT_GE(vertex[0], 3 - 1e-9);
    EXPECT_LE(vertex[0], 6 + 1e-9);
  }
  EXPECT_EQ(clipped(square, {.box = {.low = {-1, -1, -1}, .high = {11, 11, 11}}}).triangles,
            square.triangles);
}

// ---- measurements

Volume two_balls() {
  return fields::sampled<float>({30, 20, 20}, [](int x, int y, int z) {
    const auto ball = [&](double at, double radius) {
      return radius - std::sqrt((x - at) * (x - at) + (y - 10) * (y - 10) + (z - 10) * (z - 10));
    };
    return std::max(ball(8, 5.3), ball(22, 4.2));
  });
}

TEST(Certificate, MeasuresTheDistanceOfAShiftedMesh) {
  const Volume volume = two_balls();
  const DatasetPtr dataset = make_dataset(volume, "balls");
  const TriangleMesh mesh = extracted(dataset, {.isovalue = 0.0, .error = 0});
  const Certificate certificate =
      certified_against(volume, testing::shifted(mesh, {0.3, 0, 0}), {.isovalue = 0, .error = 0.2});
  for (const SurfaceDistance* way :
       {&certificate.distance.mesh_to_reference, &certificate.distance.reference_to_mesh}) {
    EXPECT_NEAR(way->maximum, 0.3, 0.06);
    EXPECT_NEAR(way->maximum_at_most, 0.3, 0.08);
    EXPECT_NEAR(way->mean, 0.15, 0.03);  // The mean of 0.3 |cos| over a sphere.
    EXPECT_NEAR(way->farthest[1], 10, 2) << "at the poles of the balls";
  }
  EXPECT_EQ(certificate.error, ErrorVerdict::kExceeded);
  EXPECT_TRUE(certificate.keeps_topology());
  EXPECT_TRUE(certificate.is_watertight());
}

TEST(Certificate, RejectsAMeshWithoutAComponent) {
  const Volume volume = two_balls();
  TriangleMesh mesh = extracted(make_dataset(volume, "balls"), {.isovalue = 0.0, .error = 0});
  std::erase_if(mesh.triangles,
                [&](const TriangleIndices& t) { return mesh.vertices[t[0]][0] > 15; });
  const Certificate certificate =
      certified_against(volume, mesh, {.isovalue = 0, .error = 0.5, .lattice = 5});
  EXPECT_EQ(certificate.mesh.components, 1);
  EXPECT_EQ(certificate.reference.components, 2);
  EXPECT_FALSE(certificate.keeps_topology());
  EXPECT_LT(certificate.distance.mesh_to_reference.maximum_at_most, 0.07);
  EXPECT_NEAR(certificate.distance.reference_to_mesh.maximum, 22 + 4.2 - 8 - 5.3, 0.1);
  EXPECT_NEAR(certificate.distance.reference_to_mesh.farthest[0], 26.2, 0.1);
  EXPECT_FALSE(certificate.passes());
}

TEST(Certificate, RejectsComponentsThatAreInsideOut) {
  const Volume volume = two_balls();
  TriangleMesh mesh = extracted(make_dataset(volume, "balls"), {.isovalue = 0.0, .error = 0.5});
  const auto turn = [&](double beyond_x) {
    for (TriangleIndices& t : mesh.triangles) {
      if (mesh.vertices[t[0]][0] > beyond_x) std::swap(t[1], t[2]);
    }
  };
  const CertifyOptions options = {.isovalue = 0, .error = 0.5, .lattice = 5};
  const auto closed = [](std::int64_t outwards, std::int64_t inwards) {
    return ClosedComponents{.outwards = outwards, .inwards = inwards};
  };
  turn(15);
  const Certificate one = certified_against(volume, mesh, options);
  EXPECT_EQ(one.closed, closed(1, 1));
  EXPECT_EQ(one.closed_of_reference, closed(2, 0));
  EXPECT_TRUE(one.keeps_topology());
  EXPECT_FALSE(one.passes());
  EXPECT_NE(text_of(one, {}, options).find("NOT KEPT: 1 component inside out"), std::string::npos)
      << text_of(one, {}, options);
  EXPECT_EQ(json_of(one, {}, options)["orientation_kept"], false);
  turn(-1e9);
  turn(15);
  const Certificate all = certified_against(volume, mesh, options);
  EXPECT_EQ(all.closed, closed(0, 2));
  EXPECT_FALSE(all.passes());
  EXPECT_NE(text_of(all, {}, options).find("--inside-out"), std::string::npos);
  CertifyOptions inside_out = options;
  inside_out.is_inside_out = true;
  EXPECT_TRUE(certified_against(volume, mesh, inside_out).passes())
      << "some programs face the other way";
}

// Two balls with a cavity each; the outer wall of one and the cavity of the other are exchanged in
// orientation, so the totals agree.
TEST(Certificate, RejectsComponentsOfExchangedOrientation) {
  const Volume volume = fields::sampled<float>({40, 20, 20}, [](int x, int y, int z) {
    const auto shell = [&](double at) {
      const double radius =
          std::sqrt((x - at) * (x - at) + (y - 9.6) * (y - 9.6) + (z - 9.7) * (z - 9.7));
      return 2 - std::abs(radius - 5);
    };
    return std::max(shell(9.3), shell(29.2));
  });
  TriangleMesh mesh = extracted(make_dataset(volume, "shells"), {.isovalue = 0.0, .error = 0.25});
  const CertifyOptions options = {.isovalue = 0, .error = 0.25, .lattice = 5};
  EXPECT_TRUE(certified_against(volume, mesh, options).passes());
  for (TriangleIndices& t : mesh.triangles) {
    const Vec3& at = mesh.vertices[t[0]];
    const bool is_left = at[0] < 20;
    const double radius = length(difference(at, {is_left ? 9.3 : 29.2, 9.6, 9.7}));
    if (is_left == (radius > 5)) std::swap(t[1], t[2]);
  }
  const Certificate certificate = certified_against(volume, mesh, options);
  EXPECT_EQ(certificate.closed, (ClosedComponents{.outwards = 2, .inwards = 2}));
  EXPECT_EQ(certificate.closed, certificate.closed_of_reference);
  EXPECT_EQ(certificate.faults.reversed, 2U);
  EXPECT_FALSE(certificate.passes());
  EXPECT_NE(text_of(certificate, {}, options).find("2 components inside out, the first at"),
            std::string::npos)
      << text_of(certificate, {}, options);
}

// A grain beside a box and a bubble in it, both smaller than the error, are exchanged in
// orientation.
TEST(Certificate, RejectsComponentsSmallerThanTheErrorThatAreInsideOut) {
  const Volume volume = fields::sampled<float>({30, 18, 18}, [](int x, int y, int z) {
    const auto ball = [&](double at) { return 1.3 - std::hypot(x - at, y - 9.0, z - 9.0); };
    const double box =
        std::min({7.2 - std::abs(x - 8.5), 7.2 - std::abs(y - 8.6), 7.2 - std::abs(z - 8.7)});
    return std::max(std::min(box, -ball(8)), ball(23));
  });
  TriangleMesh mesh = extracted(make_dataset(volume, "grains"), {.isovalue = 0.0, .error = 0});
  const CertifyOptions options = {.isovalue = 0, .error = 2, .lattice = 5};
  EXPECT_TRUE(certified_against(volume, mesh, options).passes());
  for (TriangleIndices& t : mesh.triangles) {
    const Vec3& at = mesh.vertices[t[0]];
    if (at[0] > 20 || length(difference(at, {8, 9, 9})) < 2) std::swap(t[1], t[2]);
  }
  const Certificate certificate = certified_against(volume, mesh, options);
  EXPECT_EQ(certificate.closed, certificate.closed_of_reference);
  EXPECT_EQ(certificate.faults.reversed, 2U);
  EXPECT_FALSE(certificate.passes());
}

// A rod beside a box is moved into it, by less than the error.
TEST(Certificate, RejectsAComponentOnTheOtherSideOfAnother) {
  const Volume volume = fields::sampled<float>({28, 40, 20}, [](int x, int y, int z) {
    const double box =
        std::min({8.1 - std::abs(x - 12.0), 16.2 - std::abs(y - 20.0), 6.1 - std::abs(z - 10.0)});
    const double rod = std::min(1.1 - std::hypot(x - 22.6, z - 10.2), 12.2 - std::abs(y - 20.0));
    return std::max(box, rod);
  });
  TriangleMesh mesh = extracted(make_dataset(volume, "box"), {.isovalue = 0.0, .error = 0});
  const CertifyOptions options = {.isovalue = 0, .error = 4.3, .lattice = 5};
  EXPECT_TRUE(certified_against(volume, mesh, options).passes());
  for (Vec3& at : mesh.vertices) {
    if (at[0] > 20.9) at[0] -= 4.2;
  }
  const Certificate certificate = certified_against(volume, mesh, options);
  EXPECT_TRUE(certificate.keeps_topology());
  EXPECT_NE(certificate.error, ErrorVerdict::kExceeded);
  EXPECT_EQ(certificate.faults.reversed, 0U);
  EXPECT_EQ(certificate.faults.misplaced, 1U);
  EXPECT_FALSE(certificate.passes());
}

TEST_F(CertificateErrors, DetectsAnOpenSurfaceThatIsInsideOut) {
  TriangleMesh mesh = surface(0.5);
  EXPECT_TRUE(certified(mesh, half_).passes());
  for (TriangleIndices& t : mesh.triangles) std::swap(t[1], t[2]);
  const Certificate certificate = certified(mesh, half_);
  EXPECT_TRUE(certificate.keeps_topology());
  EXPECT_GT(certificate.faults.reversed, 0U);
  EXPECT_FALSE(certificate.passes());
}

// A flat disc above an open sheet, nearer than the error.
TEST(Certificate, RejectsAComponentThatIsInsideOutNearAnOpenSheet) {
  const Volume volume = fields::sampled<float>({33, 33, 33}, [](int x, int y, int z) {
    const double wide = ((x - 16) * (x - 16) + (y - 16) * (y - 16)) / 81.0;
    const double high = (z - 12) / 0.7;
    return std::max(10.3 - z, 0.7 * (1 - std::sqrt(wide + high * high)));
  });
  TriangleMesh mesh = extracted(make_dataset(volume, "disc"), {.isovalue = 0.0, .error = 0});
  const CertifyOptions options = {.isovalue = 0, .error = 3, .lattice = 5};
  EXPECT_TRUE(certified_against(volume, mesh, options).passes());
  for (TriangleIndices& t : mesh.triangles) {
    if (mesh.vertices[t[0]][2] > 11) std::swap(t[1], t[2]);
  }
  const Certificate turned = certified_against(volume, mesh, options);
  EXPECT_EQ(turned.closed, (ClosedComponents{.outwards = 0, .inwards = 1}));
  EXPECT_EQ(turned.faults.reversed, 1U);
  EXPECT_FALSE(turned.passes());
}

// ---- allowances and other coordinates

// At this place 32-bit coordinates are half a voxel apart.
TEST(Certificate, AllowsRoundingOnlyIfAsked) {
  Volume volume = two_balls();
  volume.index_to_world.translation = {8e6, 0, 0};
  TriangleMesh mesh = extracted(make_dataset(volume, "balls"), {.isovalue = 0.0, .error = 0});
  for (Vec3& vertex : mesh.vertices) {
    for (double& coordinate : vertex) coordinate = static_cast<double>(float(coordinate));
  }
  mesh.has_floats = true;
  CertifyOptions options = {.isovalue = 0, .error = 0.05, .lattice = 5, .any_topology = true};
  const Certificate strict = certified_against(volume, mesh, options);
  EXPECT_FALSE(strict.passes());
  const std::string text = text_of(strict, {}, options);
  EXPECT_NE(text.find("allowed: 0.05 error + 0.05413 lattice = 0.1041 voxels"), std::string::npos)
      << text;
  EXPECT_NE(text.find("which --allow-rounding allows"), std::string::npos) << text;
  options.allow_rounding = true;
  const Certificate allowed = certified_against(volume, mesh, options);
  EXPECT_TRUE(allowed.passes());
  EXPECT_NE(text_of(allowed, {}, options).find(" + 0.8259 rounding of 32-bit coordinates = "),
            std::string::npos)
      << text_of(allowed, {}, options);
}

TEST(Certificate, FindsTheBorderOfRoundedMeshesIfAsked) {
  Volume volume = fields::gyroid(17, 0, 45);
  volume.index_to_world.translation = {5e5 + 0.3, 5e5 + 0.3, 0};
  TriangleMesh mesh = extracted(make_dataset(volume, "gyroid"), {.isovalue = 0.0, .error = 0.25});
  for (Vec3& vertex : mesh.vertices) {
    for (double& coordinate : vertex) coordinate = static_cast<double>(float(coordinate));
  }
  mesh.has_floats = true;
  CertifyOptions options = {.isovalue = 0, .error = 0.25, .lattice = 5};
  EXPECT_GT(certified_against(volume, mesh, options).mesh.open_edges, 0U);
  options.allow_rounding = true;
  const Certificate allowed = certified_against(volume, mesh, options);
  EXPECT_EQ(allowed.mesh.open_edges, 0U);
  EXPECT_GT(allowed.mesh.border_edges, 0U);
  EXPECT_TRUE(allowed.passes()) << text_of(allowed, {}, options);
}

TEST(Certificate, SuggestsUsualMaps) {
  Volume volume = two_balls();
  volume.index_to_world.columns[2] = {0, 0, 1.5};
  volume.index_to_world.translation = {-40, 30, 10};
  volume.meaning.space = WorldSpace::kLps;
  const TriangleMesh mesh =
      extracted(make_dataset(volume, "balls"), {.isovalue = 0.0, .error = 0.25});
  const CertifyOptions options = {
      .isovalue = 0, .error = 0.25, .lattice = 5, .any_topology = true, .try_maps = true};
  EXPECT_FALSE(certified_against(volume, mesh, options).suggestion);
  const auto suggested = [&](const Affine& map) {
    TriangleMesh mapped = mesh;
    for (Vec3& vertex : mapped.vertices) vertex = inverse(map)(vertex);
    const Certificate certificate = certified_against(volume, mapped, options);
    EXPECT_FALSE(certificate.passes());
    return certificate.suggestion ? certificate.suggestion->option : "nothing";
  };
  EXPECT_EQ(suggested({.columns = {Vec3{1e3, 0, 0}, Vec3{0, 1e3, 0}, Vec3{0, 0, 1e3}}}),
            "--scale 1000");
  EXPECT_EQ(suggested({.columns = {Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}}}), "--space ras");
  EXPECT_EQ(suggested(volume.index_to_world), "--coordinates index");
  EXPECT_EQ(suggested({.translation = volume.index_to_world.translation}),
            "--shift 40,-30,-10 (the first sample as the origin)");
  EXPECT_EQ(suggested({.translation = {3, 7, 50}}), "nothing");
  // Nor a map that changes nothing, or nothing to the better.
  volume.index_to_world = {};
  EXPECT_EQ(suggested({.translation = {100, 0, 0}}), "nothing");
  const TriangleMesh own =
      extracted(make_dataset(two_balls(), "own"), {.isovalue = 0.0, .error = 0});
  TriangleMesh moved = own;
  for (Vec3& vertex : moved.vertices) vertex[0] += 1.1;
  const Certificate near = certified_against(two_balls(), moved, options);
  EXPECT_FALSE(near.passes());
  EXPECT_FALSE(near.suggestion) << near.suggestion->option;
}

TEST(ClosedComponents, DoNotCountThoseThatRoundingMayHaveTurned) {
  // Volume 0.01 / 6 with an area of about 1.
  TriangleMesh flat{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.01}},
                    .triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  const auto counted = [&](double rounding, char is_open) {
    return counts_of(facings_of(flat, components_of(flat, {}), {is_open}, rounding));
  };
  EXPECT_EQ(counted(1e-3, 0), (ClosedComponents{.outwards = 1, .inwards = 0}));
  EXPECT_EQ(counted(1e-2, 0), ClosedComponents{});
  EXPECT_EQ(counted(1e-3, 1), ClosedComponents{});
  for (TriangleIndices& t : flat.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(counted(1e-3, 0), (ClosedComponents{.outwards = 0, .inwards = 1}));
}

// The ball around x = 22 has a diagonal of 14.5 samples, the other one of 18.4.
class WithoutTheSmallBall : public ::testing::Test {
 protected:
  WithoutTheSmallBall() {
    std::erase_if(cleaned_.triangles,
                  [&](const TriangleIndices& t) { return cleaned_.vertices[t[0]][0] > 15; });
  }
  [[nodiscard]] Certificate certified(const TriangleMesh& mesh, double min_component) {
    options_.min_component = min_component;
    return certified_against(volume_, mesh, options_);
  }

  Volume volume_ = two_balls();
  TriangleMesh whole_ = extracted(make_dataset(volume_, "balls"), {.isovalue = 0.0, .error = 0});
  TriangleMesh cleaned_ = whole_;
  CertifyOptions options_ = {.isovalue = 0, .error = 0.5, .lattice = 5};
};

TEST_F(WithoutTheSmallBall, NamesTheOptionThatExpectsItToBeMissing) {
  const Certificate certificate = certified(cleaned_, 0);
  EXPECT_FALSE(certificate.passes());
  ASSERT_TRUE(certificate.missing);
  EXPECT_EQ(certificate.missing->count, 1U);
  EXPECT_NEAR(certificate.missing->largest_diagonal, 14.5, 0.1);
  EXPECT_EQ(certificate.missing->min_component, 15);
  const std::string text = text_of(certificate, {}, options_);
  EXPECT_NE(text.find("--min-component 15."), std::string::npos) << text;
  EXPECT_EQ(json_of(certificate, {}, options_)["missing_components"]["count"], 1);
  options_.error.reset();
  EXPECT_TRUE(certified(cleaned_, 0).missing) << "only the topology differs";
}

TEST_F(WithoutTheSmallBall, AcceptsTheReducedMeshOnlyWithTheOption) {
  const Certificate certificate = certified(cleaned_, 15);
  EXPECT_TRUE(certificate.passes()) << text_of(certificate, {}, options_);
  EXPECT_EQ(certificate.reference.components, 1);
  EXPECT_FALSE(certificate.missing);
  EXPECT_EQ(certificate.left_out.count, 0U) << "it is below the limit";
  const Certificate lower = certified(cleaned_, 14);
  EXPECT_TRUE(lower.passes()) << "the error may move it across the limit";
  EXPECT_EQ(lower.left_out.count, 1U);
  EXPECT_NE(text_of(lower, {}, options_).find("1 component of the full surface with up to 14.5"),
            std::string::npos)
      << text_of(lower, {}, options_);
  EXPECT_TRUE(certified(whole_, 15).passes()) << "likewise";
  options_.error = 0.02;
  EXPECT_TRUE(certified(whole_, 14).passes());
  EXPECT_FALSE(certified(whole_, 15).passes()) << "it is too small to be there";
  EXPECT_TRUE(certified(cleaned_, 15).passes());
  EXPECT_FALSE(certified(cleaned_, 14).passes()) << "it is too large to be missing";
}

TEST_F(WithoutTheSmallBall, OmitsTheHintIfTheRestDiffersToo) {
  EXPECT_FALSE(certified(testing::shifted(cleaned_, {2, 0, 0}), 0).missing);
  EXPECT_FALSE(certified({}, 0).missing);
}

// The mesh lacks the inner side of a shell. It lies within the error of the outer side, so
// distances alone do not show which of the two is missing.
TEST(Certificate, AcceptsEitherCountOfComponentsNearTheSizeLimit) {
  const Vec3 center = {12, 12, 12};
  const Volume volume = fields::sampled<float>({25, 25, 25}, [&](int x, int y, int z) {
    const Vec3 at = {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    return 1 - std::abs(length(difference(at, center)) - 7);
  });
  TriangleMesh mesh = extracted(make_dataset(volume, "shell"), {.isovalue = 0.0, .error = 0});
  CertifyOptions options{.isovalue = 0, .error = 2, .lattice = 5, .min_component = 24};
  EXPECT_TRUE(certified_against(volume, mesh, options).passes());
  std::erase_if(mesh.triangles, [&](const TriangleIndices& t) {
    return length(difference(mesh.vertices[t[0]], center)) < 7;
  });
  const Certificate certificate = certified_against(volume, mesh, options);
  EXPECT_TRUE(certificate.passes()) << text_of(certificate, {}, options);
  EXPECT_EQ(certificate.reference.components, 1);
  options.min_component = 10;
  EXPECT_FALSE(certified_against(volume, mesh, options).passes());
}

TEST(Certificate, AllowsBoundaryEdgesAtTheMask) {
  const Volume volume = fields::masked_gyroid(33, 10);
  const DatasetPtr dataset = make_dataset(volume, "masked");
  TriangleMesh mesh = extracted(dataset, {.isovalue = 0.1, .error = 0});
  const Certificate whole =
      certified_against(volume, mesh, {.isovalue = 0.1, .error = 0, .lattice = 5});
  EXPECT_EQ(whole.mesh.open_edges, 0);
  EXPECT_GT(whole.mesh.border_edges, 0);
  EXPECT_TRUE(whole.passes());
}

TEST(Certificate, WeldsSeparateCorners) {
  const Volume volume = two_balls();
  const TriangleMesh mesh =
      extracted(make_dataset(volume, "balls"), {.isovalue = 0.0, .error = 0.5});
  TriangleMesh soup;
  for (const TriangleIndices& t : mesh.triangles) {
    for (const std::uint32_t corner : t) soup.vertices.push_back(mesh.vertices[corner]);
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.push_back({n - 3, n - 2, n - 1});
    soup.triangles.push_back({n - 3, n - 3, n - 1});
  }
  const CertifyOptions options{.isovalue = 0, .error = 0.5, .lattice = 5};
  const Certificate of_mesh = certified_against(volume, mesh, options);
  const Certificate of_soup = certified_against(volume, soup, options);
  EXPECT_EQ(of_soup.mesh, of_mesh.mesh);
  EXPECT_EQ(of_soup.maximum(), of_mesh.maximum());
  EXPECT_EQ(of_soup.degenerate_triangles, mesh.triangles.size());
  EXPECT_TRUE(of_soup.passes());
}

TEST(Certificate, CountsNonmanifoldVertices) {
  const TriangleMesh bowtie = welded(testing::joined(testing::box({0, 0, 0}, {1, 1, 1}),
                                                     testing::box({1, 1, 1}, {2, 2, 2})))
                                  .mesh;
  EXPECT_EQ(nonmanifold_vertices(bowtie.vertices.size(), bowtie.triangles), 1);
  const TriangleMesh at_edge = welded(testing::joined(testing::box({0, 0, 0}, {1, 1, 1}),
                                                      testing::box({1, 1, 0}, {2, 2, 1})))
                                   .mesh;
  const MeshTopology found =
      topology(at_edge.vertices.size(), at_edge.triangles, [](auto, auto) { return false; });
  EXPECT_EQ(found.nonmanifold_edges, 1);
  EXPECT_EQ(found.components, 1);
}

// ---- the report

TEST(CertificateReport, StartsWithTheVerdictAndContainsTheNumbers) {
  const Volume volume = two_balls();
  const TriangleMesh mesh =
      extracted(make_dataset(volume, "balls"), {.isovalue = 0.0, .error = 0.5});
  CertifyOptions options{
      .isovalue = 0, .error = 0.5, .lattice = 5, .count_self_intersections = true};
  const CertifiedFiles files{.mesh = "balls.ply",
                             .volume = "balls.nrrd",
                             .volume_notices = {"samples of type f64 become f32."}};
  const Certificate kept = certify(mesh, volume, options);
  EXPECT_TRUE(text_of(kept, files, options).starts_with("Certified: balls.ply"))
      << text_of(kept, files, options);
  CertifyOptions only_measured = options;
  only_measured.error.reset();
  EXPECT_TRUE(text_of(certify(mesh, volume, only_measured), files, only_measured)
                  .starts_with("Measured only: balls.ply"));
  EXPECT_NE(text_of(kept, files, options)
                .find("Of the volume as it was read:\n  samples of type f64 become f32.\n"),
            std::string::npos);
  const auto json = json_of(kept, files, options);
  EXPECT_EQ(json["volume_notices"][0], files.volume_notices[0]);
  EXPECT_EQ(json["kept"], true);
  EXPECT_EQ(json["error"]["proven"], true);
  EXPECT_EQ(json["topology_kept"], true);
  EXPECT_EQ(json["watertight"], true);
  EXPECT_EQ(json["mesh"]["components"], 2);
  EXPECT_EQ(json["full_surface"]["euler_characteristic"], 4);
  EXPECT_EQ(json["distances"]["mesh_to_full"]["samples"], 200'000);
  EXPECT_EQ(json["distances"]["mesh_to_full"]["world"]["maximum"],
            kept.distance.mesh_to_reference.maximum);
  EXPECT_TRUE(json["self_intersections"].is_object());
  CertifyOptions filtered = options;
  filtered.min_component = 12;
  EXPECT_NE(text_of(kept, files, filtered).find("that --min-component leaves out"),
            std::string::npos);
  Certificate open = kept;
  open.error = ErrorVerdict::kUndecided;
  open.distance.mesh_to_reference.undecided = 1234;
  const std::string text = text_of(open, files, options);
  EXPECT_TRUE(text.starts_with("Kept where measured, not proven between: balls.ply")) << text;
  EXPECT_NE(text.find("1 234 pieces of triangles are undecided"), std::string::npos) << text;
  EXPECT_EQ(json_of(open, files, options)["distances"]["mesh_to_full"]["undecided_pieces"], 1234);
  options.error = 0.01;
  options.lattice.reset();
  const Certificate exceeded = certified_against(volume, mesh, options);
  EXPECT_TRUE(text_of(exceeded, files, options).starts_with("NOT certified: balls.ply"));
  EXPECT_EQ(json_of(exceeded, files, options)["error"]["kept"], false);
  options.error = exceeded.maximum() - 1e-3;
  const std::string barely = text_of(certified_against(volume, mesh, options), files, options);
  EXPECT_NE(barely.find("which --lattice 5 allows"), std::string::npos) << barely;
}

}  // namespace
}  // namespace multitetra

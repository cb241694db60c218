// Reads meshes in every format the project writes, other programs' variants, and damaged files.
#include "server/certify/mesh_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "common/wire/detail/three_mf_file.hpp"
#include "common/wire/detail/triangle_normals.hpp"
#include "common/wire/lattice_glb.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/mesh_readers.hpp"
#include "common/wire/polygon_sink.hpp"
#include "common/wire/scene_file.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using Corners = std::array<Vec3, 3>;

class MeshFile : public ::testing::Test {
 protected:
  TriangleMesh read(const std::string& name, const std::string& bytes) {
    return read_mesh(folder_.file(name, bytes));
  }
  std::string complaint(const std::string& name, const std::string& bytes) {
    try {
      (void)read(name, bytes);
    } catch (const VolumeFileError& error) {
      return error.what();
    }
    return "none";
  }

  TemporaryFolder folder_;
};

PositionedMesh world_mesh() {
  const Affine to_world{.columns = {Vec3{0.7, 0, 0}, Vec3{0, 1.3, 0.1}, Vec3{0, 0, 2}},
                        .translation = {-500.25, 1000, 3}};
  PositionedMesh mesh = positioned(surfaces::torus(5, 12, 8, 0.2, 1), to_world);
  mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
  mesh.scalars.assign(mesh.positions.size(), 7);
  mesh.colors.assign(mesh.positions.size(), {1, 2, 3});
  return mesh;
}

// The sorted triangles, each starting at its least corner. Coordinates are floats, as the decimals
// of text files are not exact.
std::vector<Corners> sorted_corners(const TriangleMesh& mesh) {
  std::vector<Corners> all;
  for (const TriangleIndices& t : mesh.triangles) {
    Corners corners = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    for (Vec3& corner : corners) {
      for (double& v : corner) v = static_cast<double>(static_cast<float>(v));
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    all.push_back(corners);
  }
  std::sort(all.begin(), all.end());
  return all;
}

TriangleMesh as_triangles(const PositionedMesh& mesh) {
  TriangleMesh result;
  for (const auto& p : mesh.positions) result.vertices.push_back(p);
  result.triangles = mesh.triangles;
  return result;
}

TEST_F(MeshFile, RoundTripsEveryFormat) {
  const PositionedMesh mesh = world_mesh();
  const auto expected = sorted_corners(as_triangles(mesh));
  for (const auto& [name, format] : {std::pair("a.ply", MeshFormat::kPly),
                                     {"a.stl", MeshFormat::kStl},
                                     {"a.obj", MeshFormat::kObj},
                                     {"a.glb", MeshFormat::kGlb},
                                     {"a.vtp", MeshFormat::kVtp},
                                     {"a.3mf", MeshFormat::k3mf}}) {
    SCOPED_TRACE(name);
    const WeldedMesh read_back = welded(read(name, mesh_file(mesh, format)));
    EXPECT_EQ(sorted_corners(read_back.mesh), expected);
    EXPECT_EQ(read_back.mesh.vertices.size(), mesh.positions.size());
    EXPECT_EQ(read_back.degenerate_triangles, 0U);
  }
  const TriangleMesh draco = welded(read("a.drc", mesh_file(mesh, MeshFormat::kDrc))).mesh;
  EXPECT_EQ(draco.vertices.size(), mesh.positions.size());
  EXPECT_EQ(draco.triangles.size(), mesh.triangles.size());
}

TEST_F(MeshFile, NamesLatticeAndRemovedComponents) {
  const PositionedMesh mesh = world_mesh();
  for (const auto& [name, format] : {std::pair("a.ply", MeshFormat::kPly),
                                     {"a.stl", MeshFormat::kStl},
                                     {"a.obj", MeshFormat::kObj},
                                     {"a.3mf", MeshFormat::k3mf}}) {
    SCOPED_TRACE(name);
    const TriangleMesh cleaned = read(
        name,
        mesh_file(mesh, format,
                  {.name = {.text = "liver", .label = 17}, .lattice = 7, .min_component = 12.5}));
    EXPECT_EQ(cleaned.lattice, 7);
    EXPECT_EQ(cleaned.min_component, 12.5);
    const TriangleMesh whole = read(name, mesh_file(mesh, format));
    EXPECT_EQ(whole.lattice, std::nullopt);
    EXPECT_EQ(whole.min_component, 0);
    const MeshFileFacts wrong{.lattice = kMaxLatticeResolution + 1};
    EXPECT_EQ(read(name, mesh_file(mesh, format, wrong)).lattice, std::nullopt);
  }
}

TEST_F(MeshFile, AppliesNodeTransformsToCompressedCells) {
  const LatticeMesh mesh = surfaces::torus(5, 12, 8, 0.2, 1);
  const Vec3 step = {0.5, 2, 3};
  TriangleMesh expected;
  for (const LatticePoint& p : mesh.vertices) {
    const Vec3 x = grid_coordinates(p, mesh.resolution);
    expected.vertices.push_back({x[0] * step[0], x[1] * step[1], x[2] * step[2]});
  }
  expected.triangles = mesh.triangles;
  for (const CellCodec codec : {CellCodec::kDraco, CellCodec::kMeshopt}) {
    const std::string file = lattice_glb(mesh, {.exponent = 6}, step, {}, codec);
    EXPECT_EQ(sorted_corners(welded(read("a.glb", file)).mesh), sorted_corners(expected))
        << kCellCodecs.of(codec);
  }
}

TEST_F(MeshFile, ReadsMeshoptWithinItsRounding) {
  PositionedMesh mesh = world_mesh();
  const MeshFileFacts packed{.codec = MeshCodec::kMeshopt};
  const std::string file = mesh_file(mesh, MeshFormat::kGlb, packed);
  EXPECT_LT(4 * file.size(), 3 * mesh_file(mesh, MeshFormat::kGlb).size()) << "of few vertices";
  const TriangleMesh found = welded(read("a.glb", file)).mesh;
  ASSERT_EQ(found.vertices.size(), mesh.positions.size());
  EXPECT_EQ(found.triangles.size(), mesh.triangles.size());
  const double rounding = position_rounding(mesh);
  EXPECT_GT(rounding, 0);
  for (const auto& p : mesh.positions) {
    double nearest = 1e300;
    for (const Vec3& q : found.vertices) {
      nearest = std::min(nearest, squared_length(difference(p, q)));
    }
    // Matrices of files are floats to most programs, but not here.
    EXPECT_LE(std::sqrt(nearest), 1.000001 * rounding);
  }
}

TEST_F(MeshFile, KeepsPositionsThatRoundingWouldMerge) {
  PositionedMesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e6F, 0, 0}},
                      .triangles = {{0, 1, 2}, {1, 3, 2}}};
  const std::string file = mesh_file(mesh, MeshFormat::kGlb, {.codec = MeshCodec::kMeshopt});
  EXPECT_EQ(sorted_corners(read("a.glb", file)), sorted_corners(as_triangles(mesh)));
}

// Every change must be refused or read as some mesh.
TEST_F(MeshFile, RefusesDamagedMeshopt) {
  const std::string file =
      mesh_file(world_mesh(), MeshFormat::kGlb, {.codec = MeshCodec::kMeshopt});
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = file;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  EXPECT_NE(complaint("a.glb", changed("ATTRIBUTES", "SOMETHINGS")).find("mode 'SOMETHINGS'"),
            std::string::npos);
  EXPECT_NE(complaint("a.glb", changed(R"("byteStride":8,"count")", R"("byteStride":9,"count")"))
                .find("damaged"),
            std::string::npos);
  int refused = 0;
  for (std::size_t at = file.size() - 400; at < file.size(); ++at) {
    std::string damaged = file;
    damaged[at] = static_cast<char>(~damaged[at]);
    try {
      (void)read_mesh_here(folder_.file("a.glb", damaged));
    } catch (const VolumeFileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
}

// ---- PLY

TEST_F(MeshFile, ReadsTextPlyWithPolygonsAndOtherElements) {
  const TriangleMesh mesh = read("a.ply",
                                 "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement vertex 5\n"
                                 "property double y\nproperty list uchar int tags\n"
                                 "property double x\nproperty float z\nproperty uchar red\n"
                                 "element face 2\nproperty uchar flags\n"
                                 "property list uchar uint vertex_index\n"
                                 "element edge 1\nproperty int vertex1\nend_header\n"
                                 "0 0 0 0 9\n0 2 5 6 1 0 9\n1 0 1 0 9\n1 0 0 0 9\n"
                                 ".5 1 3 +5e-1 1e0 9\n0 4 0 1 2 3\n1 3 0 1 4\n7\n");
  EXPECT_EQ(mesh.vertices,
            (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, 1}}));
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}}));
}

TEST_F(MeshFile, ReadsBigEndianPly) {
  std::string file =
      "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 3\r\nproperty short x\r\n"
      "property float y\r\nproperty double z\r\nelement face 1\r\n"
      "property list int16 int32 vertex_indices\r\nend_header\r\n";
  const auto add = [&](auto value) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    file.append(bytes.rbegin(), bytes.rend());
  };
  for (int i = 0; i < 3; ++i) {
    add(static_cast<std::int16_t>(-i));
    add(0.5F * static_cast<float>(i * i));
    add(1e-9 * i);
  }
  add(std::int16_t{3});
  for (const std::int32_t corner : {2, 0, 1}) add(corner);
  const TriangleMesh mesh = read("a.ply", file);
  EXPECT_EQ(mesh.vertices, (std::vector<Vec3>{{0, 0, 0}, {-1, 0.5, 1e-9}, {-2, 2, 2e-9}}));
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{2, 0, 1}}));
}

TEST_F(MeshFile, RejectsTruncatedPly) {
  const std::string head = "ply\nformat ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_NE(complaint("a.ply", head + "element vertex 4000000000\n" + xyz + "end_header\n0 0 0\n")
                .find("shorter than the 4000000000 elements"),
            std::string::npos);
  EXPECT_NE(complaint("a.ply", head + "element vertex 1\nproperty float x\nend_header\n0\n")
                .find("do not have x, y and z"),
            std::string::npos);
  EXPECT_NE(complaint("a.ply", head + "element vertex 1\n" + xyz +
                                   "element face 1\nproperty list uchar int vertex_indices\n"
                                   "end_header\n0 0 0\n3 0 0 1\n")
                .find("has the vertex 1 of 1"),
            std::string::npos);
  EXPECT_NE(complaint("a.ply", head + "element vertex 1\n" + xyz + "end_header\n0 nan 0\n")
                .find("is not a number"),
            std::string::npos);
  EXPECT_NE(complaint("a.ply", head + "element vertex 1\n" + xyz).find("header has no end_header"),
            std::string::npos);
}

// ---- STL and OBJ

TEST_F(MeshFile, ReadsTextStlAndBinaryStlThatStartsLikeText) {
  const TriangleMesh mesh = read("a.STL",
                                 "solid thing\r\n facet normal 0 0 1\r\n  outer loop\r\n"
                                 "   vertex 0 0 0\r\n   vertex 1e0 0 0\r\n   vertex 0 1.5 0\r\n"
                                 "  endloop\r\n endfacet\r\nendsolid thing\r\n");
  EXPECT_EQ(mesh.vertices, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1.5, 0}}));
  EXPECT_EQ(mesh.triangles.size(), 1U);
  std::string binary = mesh_file(world_mesh(), MeshFormat::kStl);
  std::memcpy(binary.data(), "solid", 5);
  EXPECT_EQ(read("b.stl", binary).triangles.size(), world_mesh().triangles.size());
  // As some programs write them: capitals, a blank first line or byte order mark, bytes after the
  // triangles.
  const std::string facet =
      "FACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\nENDLOOP\n"
      "ENDFACET\n";
  for (const std::string& text :
       {"SOLID THING\n" + facet + "ENDSOLID THING\n", "\r\n  \nSolid\n" + facet + "EndSolid\n",
        "\xEF\xBB\xBFsolid\n" + facet + "endsolid\n"}) {
    EXPECT_EQ(read("c.stl", text).triangles.size(), 1U) << text;
    EXPECT_EQ(read("any.name", text).triangles.size(), 1U) << text;
  }
  EXPECT_EQ(read("b.stl", mesh_file(world_mesh(), MeshFormat::kStl) + std::string(7, '\n'))
                .triangles.size(),
            world_mesh().triangles.size());
  // But no triangles behind those that the header declares.
  const std::string whole = mesh_file(world_mesh(), MeshFormat::kStl);
  EXPECT_NE(complaint("two.stl", whole + whole).find("declares"), std::string::npos);
  EXPECT_EQ(read("a.dat", mesh_file(world_mesh(), MeshFormat::kStl)).triangles.size(),
            world_mesh().triangles.size());
  EXPECT_EQ(read("a.txt", mesh_file(world_mesh(), MeshFormat::kObj)).triangles.size(),
            world_mesh().triangles.size());
}

TEST_F(MeshFile, RecommendsACompleteCopyOnlyOfAFileThatIsTooShort) {
  const std::string cut = complaint("c.stl", "solid thing\nfacet\nvertex 0 0 0\n");
  EXPECT_NE(cut.find("ends too early. Get a complete copy"), std::string::npos) << cut;
  std::string face = "v 0 0 0\nf";
  for (std::size_t i = 0; i <= kMaxPolygonCorners; ++i) face += " 1";
  const std::string polygon = complaint("c.obj", face + "\n");
  EXPECT_NE(polygon.find("more than 65536 corners. Save it as PLY with triangles alone"),
            std::string::npos)
      << polygon;
}

TEST_F(MeshFile, ReadsNegativeObjIndices) {
  const TriangleMesh mesh = read("a.obj",
                                 "# by hand\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\n"
                                 "v 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3/1 4\nv 5 5 5\n"
                                 "f -1 -5 -4\nl 1 2\n");
  EXPECT_EQ(mesh.vertices.size(), 5U);
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{0, 1, 2}, {0, 2, 3}, {4, 0, 1}}));
  EXPECT_NE(complaint("a.obj", "v 0 0 0\nf 0 1 1\n").find("has the vertex -1"), std::string::npos);
  EXPECT_NE(complaint("a.obj", "v 0 0 0\nf 1 1 x\n").find("'x' is not a valid integer"),
            std::string::npos);
}

TEST_F(MeshFile, ReadsObjOfManyPrograms) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const std::vector<TriangleIndices> whole = {{0, 1, 2}, {0, 2, 3}};
  for (const std::string_view faces :
       {"f 1 2 3 4\n", "fo 1 2 3 4\n", "F 1 2 3 4\n", "f 1 2 \\\n3 \\\n4\n",
        "# C:\\parts\\\nf 1 2 3 4\n", "o a\\\nf 1 2 3 4\n"}) {
    EXPECT_EQ(read("a.obj", square + std::string(faces)).triangles, whole) << faces;
    std::string mac = square + std::string(faces);
    std::replace(mac.begin(), mac.end(), '\n', '\r');
    EXPECT_EQ(read("a.obj", mac).triangles, whole) << faces;
  }
  EXPECT_NE(complaint("a.obj", square + "surf 0 1 0 1 1 2 3 4\n").find("free-form surfaces"),
            std::string::npos);
}

TEST_F(MeshFile, ReadsTextStlWithoutLines) {
  const std::string facet =
      "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
  const std::string two = facet + facet;
  for (const std::string& text :
       {"solid a part " + two + "endsolid a part",
        "solid vertex of facets\n" + two + "endsolid vertex\n", "solid\r" + two + "\rendsolid\r"}) {
    const TriangleMesh mesh = read("a.stl", text);
    EXPECT_EQ(mesh.triangles.size(), 2U) << text;
    EXPECT_EQ(mesh.vertices[2], (Vec3{0, 1, 0}));
  }
  // Cut within the second of two solids.
  const std::string first = "solid a " + two + "endsolid a ";
  EXPECT_EQ(read("a.stl", first + "solid b facet\tnormal" + two.substr(12) + "endsolid b")
                .triangles.size(),
            4U);
  EXPECT_NE(complaint("a.stl", first + "solid b " + facet).find("ends too early"),
            std::string::npos);
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += "solid x endsolid x ";
  EXPECT_EQ(read("a.stl", many + "solid y " + facet + "endsolid y").triangles.size(), 1U);
  // Quadrilaterals, three of which have as many corners as four triangles.
  const std::string four =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\n"
      "endloop\nendfacet\n";
  const std::string said = complaint("a.stl", "solid a\n" + four + four + four + "endsolid a\n");
  EXPECT_NE(said.find("a facet has 4 corners"), std::string::npos) << said;
}

// ---- polygons

double area_of(const TriangleMesh& mesh, const Vec3& normal) {
  double area = 0;
  for (const TriangleIndices& t : mesh.triangles) {
    const double part =
        dot(area_vector(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]), normal);
    EXPECT_GE(part, 0);
    area += part / 2;
  }
  return area;
}

std::string obj_polygon(const std::vector<Vec3>& corners) {
  std::string file;
  std::string face = "f";
  for (const Vec3& corner : corners) {
    file += "v " + std::to_string(corner[0]) + ' ' + std::to_string(corner[1]) + ' ' +
            std::to_string(corner[2]) + '\n';
    face += ' ' + std::to_string(&corner - corners.data() + 1);
  }
  return file + face + '\n';
}

TEST_F(MeshFile, CutsConcavePolygonsInside) {
  const std::vector<Vec3> arrow = {{0, 0, 0}, {3, 2, 0}, {0, 4, 0}, {1, 2, 0}};
  // A comb, whose fan would cover the gaps between its teeth.
  const std::vector<Vec3> comb = {{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 3, 0}, {4, 1, 0}, {3, 1, 0},
                                  {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  // A square with a hole, joined by an edge in both directions.
  const std::vector<Vec3> ring = {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {0, 0, 0},
                                  {1, 1, 0}, {1, 2, 0}, {2, 2, 0}, {2, 1, 0}, {1, 1, 0}};
  for (const auto& [polygon, area] :
       {std::pair(arrow, 4.0), std::pair(comb, 11.0), std::pair(ring, 8.0)}) {
    for (std::size_t turns = 0; turns < polygon.size(); ++turns) {  // From each corner.
      std::vector<Vec3> turned = polygon;
      std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(turns),
                  turned.end());
      const TriangleMesh flat = read("a.obj", obj_polygon(turned));
      EXPECT_EQ(flat.triangles.size(), polygon.size() - 2);
      EXPECT_DOUBLE_EQ(area_of(flat, {0, 0, 1}), area);
      for (Vec3& corner : turned) corner = {7, -corner[1], corner[0]};
      EXPECT_DOUBLE_EQ(area_of(read("a.obj", obj_polygon(turned)), {1, 0, 0}), area);
      std::reverse(turned.begin(), turned.end());
      EXPECT_DOUBLE_EQ(area_of(read("a.obj", obj_polygon(turned)), {-1, 0, 0}), area);
    }
  }
}

TEST(PolygonSink, EndsWhenConcavePolygonsTakeTooLong) {
  TriangleMesh mesh;
  for (int i = 0; i < 200; ++i) {  // A star.
    const double radius = 1 + i % 2;
    mesh.vertices.push_back(
        {radius * std::cos(i * 0.0314159), radius * std::sin(i * 0.0314159), 0});
  }
  PolygonSink sink(mesh, 30'000);
  const auto add = [&] {
    sink.begin();
    for (int i = 0; i < 200; ++i) sink.add(i);
    sink.end();
  };
  add();
  EXPECT_EQ(mesh.triangles.size(), 198U);
  EXPECT_THROW(add(), MeshFileError);
}

TEST_F(MeshFile, SaysThatAPolygonCrossesItself) {
  std::vector<Vec3> star;
  for (int i = 0; i < 5; ++i) star.push_back({std::cos(i * 2.513274), std::sin(i * 2.513274), 0});
  EXPECT_NE(complaint("a.obj", obj_polygon(star)).find("a face of 5 corners crosses itself"),
            std::string::npos);
  // A warped quadrilateral may look crossed, and has two triangles all the same.
  const std::vector<Vec3> bow = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(read("a.obj", obj_polygon(bow)).triangles.size(), 2U);
  // Rounded coordinates: a disc of many corners, and a face thinner than they can tell.
  std::vector<Vec3> disc;
  for (int i = 0; i < 5000; ++i) {
    disc.push_back({static_cast<float>(100 + std::cos(i * 0.00125663706)),
                    static_cast<float>(100 + std::sin(i * 0.00125663706)), 7});
  }
  EXPECT_EQ(read("a.obj", obj_polygon(disc)).triangles.size(), 4998U);
  std::vector<Vec3> thin;
  for (int i = 0; i <= 20; ++i)
    thin.push_back({static_cast<float>(50'000 + 5 * i), static_cast<float>(50'000 + 3.3 * i), 0});
  for (int i = 19; i > 0; --i)
    thin.push_back(
        {static_cast<float>(50'000 + 5 * i), static_cast<float>(50'000.001 + 3.3 * i), 0});
  EXPECT_EQ(read("a.obj", obj_polygon(thin)).triangles.size(), thin.size() - 2);
  // On a line: no area, but nothing is lost or refused.
  const std::vector<Vec3> line = {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {3, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(read("a.obj", obj_polygon(line)).triangles.size(), 3U);
}

// ---- glTF

std::string glb(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string file = "glTF";
  const auto add = [&](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    file.append(reinterpret_cast<const char*>(&number), 4);
  };
  add(2);
  add(20 + json.size() + 8 + binary.size());
  add(json.size());
  add(0x4E4F534A);
  file += json;
  add(binary.size());
  add(0x004E4942);
  return file + binary;
}

// A triangle with positions as shorts and indices as bytes, and nested nodes.
std::string nested_glb(const std::string& nodes, const std::string& count = "3") {
  std::string binary;
  for (const std::int16_t v : std::array<std::int16_t, 12>{0, 0, 0, 99, 1, 0, 0, 99, 0, 1, 0, 99}) {
    binary.append(reinterpret_cast<const char*>(&v), 2);
  }
  binary += std::string("\x02\x00\x01", 3);
  return glb(R"({"asset":{"version":"2.0"},"scene":1,"scenes":[{},{"nodes":[0]}],"nodes":)" +
                 nodes +
                 R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
      "accessors":[{"bufferView":0,"componentType":5122,"count":)" +
                 count + R"(,"type":"VEC3"},
                   {"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}],
      "bufferViews":[{"buffer":0,"byteLength":24,"byteStride":8},
                     {"buffer":0,"byteOffset":24,"byteLength":3}],
      "buffers":[{"byteLength":27}],"extensionsRequired":["KHR_mesh_quantization"]})",
             binary);
}

TEST_F(MeshFile, ReadsAllNodesOfGltf) {
  const TriangleMesh mesh = read("a.glb", nested_glb(R"([{"children":[1],"translation":[10,20,30]},
                              {"children":[2],"rotation":[0,1,0,0]},{"mesh":0,"scale":[3,3,3]}])"));
  // A half turn about y maps x to -x; (x, y, z) with y up is (x, -z, y) with z up.
  EXPECT_EQ(mesh.vertices, (std::vector<Vec3>{{10, -30, 20}, {7, -30, 20}, {10, -30, 23}}));
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{2, 0, 1}}));
  const TriangleMesh mirrored = read("b.glb", nested_glb(R"([{"mesh":0,"scale":[-1,1,1]}])"));
  EXPECT_EQ(mirrored.triangles, (std::vector<TriangleIndices>{{2, 1, 0}})) << "turned over";
}

TEST_F(MeshFile, RejectsInvalidGltf) {
  EXPECT_NE(complaint("a.glb", nested_glb(R"([{"children":[0]}])")).find("form a cycle"),
            std::string::npos);
  EXPECT_NE(complaint("a.glb", nested_glb(R"([{"mesh":1}])")).find("'meshes'"), std::string::npos);
  EXPECT_NE(complaint("a.glb", nested_glb(R"([{"mesh":-1}])")).find("Cannot read"),
            std::string::npos);
  EXPECT_NE(
      complaint("a.glb", glb(R"({"scenes":[{}],"extensionsRequired":["EXT_texture_webp"]})", ""))
          .find("'EXT_texture_webp'"),
      std::string::npos);
  EXPECT_NE(complaint("a.glb", glb("{", "")).find("JSON"), std::string::npos);
  // What places a mesh elsewhere, also if the file does not require readers to know it.
  EXPECT_NE(complaint("a.glb", nested_glb(R"([{"mesh":0,"skin":0}])")).find("skin"),
            std::string::npos);
  EXPECT_NE(
      complaint("a.glb", nested_glb(R"([{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}}])"))
          .find("instances"),
      std::string::npos);
  std::string morphed = nested_glb(R"([{"mesh":0}])");
  const std::size_t at = morphed.find(R"("indices":1)");
  morphed.replace(at, 11, R"("targets":1)");
  EXPECT_NE(complaint("a.glb", morphed).find("morph targets"), std::string::npos);
}

// A million instances of ten thousand primitives without triangles: of points, or of no vertices.
TEST_F(MeshFile, LooksThroughAMeshOnceForAllInstances) {
  const auto times = [](int count, const std::string& text) {
    std::string list = text;
    for (int i = 1; i < count; ++i) list += "," + text;
    return "[" + list + "]";
  };
  const std::string nodes = R"([{"children":)" + times(99, "1") + R"(},{"children":)" +
                            times(99, "2") + R"(},{"children":)" + times(99, "3") +
                            R"(},{"mesh":0}])";
  const auto begin = std::chrono::steady_clock::now();
  for (const char* mode : {"0", "4"}) {
    const std::string json =
        R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
        R"(,"accessors":[{"componentType":5126,"count":0,"type":"VEC3"}],"meshes":[{"primitives":)" +
        times(10'000, R"({"attributes":{"POSITION":0},"mode":)" + std::string(mode) + "}") + "}]}";
    EXPECT_EQ(read_glb(glb(json, "")).triangles.size(), 0u);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::minutes(1));
}

// Before an array is read, which is shorter than it says here.
TEST_F(MeshFile, CountsTheVerticesOfAllInstancesFirst) {
  std::string nodes = R"([{"children":[1)";
  for (int i = 0; i < 99; ++i) nodes += ",1";
  const std::string file = nested_glb(nodes + R"(]},{"mesh":0}])", "3000000");
  EXPECT_NE(complaint("a.glb", file).find("counting all instances"), std::string::npos);

  std::string model =
      "<model><resources><object id='1'><mesh><triangles><triangle v1='0' v2='1' "
      "v3='70000'/></triangles><vertices>";
  for (int i = 0; i < 30'000; ++i) model += "<vertex x='0' y='0' z='0'/>";
  model += "</vertices></mesh></object></resources><build>";
  for (int i = 0; i < 10'000; ++i) model += "<item objectid='1'/>";
  const auto problem = [](const std::string& text) -> std::string {
    try {
      (void)read_three_mf_model(text + "</build></model>");
      return "none";
    } catch (const MeshFileError& error) {
      return error.what();
    }
  };
  EXPECT_NE(problem(model).find("counting all instances"), std::string::npos);
  std::string items = "<model><resources><object id='1'/></resources><build>";
  for (int i = 0; i <= 1'000'000; ++i) items += "<item objectid='1'/>";
  EXPECT_NE(problem(items).find("a million items"), std::string::npos);
}

// ---- VTP

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0U);
    }
    for (std::size_t j = 0; j < 4; ++j) {
      text += i + j > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * j) & 63];
    }
  }
  return text;
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string zipped(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()),
            Z_OK);
  packed.resize(size);
  return packed;
}

// Two triangles as a polygon of four corners, and a strip of two more.
std::string vtp(
    const std::string& attributes, const std::string& format,
    const std::function<std::string(const std::string& bytes, const std::string& text)>& array) {
  const auto tag = [&](const std::string& type, const std::string& name, const std::string& more,
                       const std::string& bytes, const std::string& text) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"" + format + "\"" +
           more + ">\n" + array(bytes, text) + "\n</DataArray>\n";
  };
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt64\"" +
         attributes +
         ">\n<PolyData>\n<Piece NumberOfPoints=\"6\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
         "NumberOfStrips=\"1\" NumberOfPolys=\"1\">\n<PointData></PointData>\n<Points>\n" +
         tag("Float64", "Points", " NumberOfComponents=\"3\"",
             bytes_of(std::vector<double>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 2, 1, 0, 2}),
             "0 0 0 1 0 0 1 1 0\n0 1 0 0 0 2 1 0 2") +
         "</Points>\n<Verts></Verts>\n<Strips>\n" +
         tag("Int32", "connectivity", "", bytes_of(std::vector<std::int32_t>{0, 1, 4, 5}),
             "0 1 4 5") +
         tag("Int32", "offsets", "", bytes_of(std::vector<std::int32_t>{4}), "4") +
         "</Strips>\n<Polys>\n" +
         tag("Int64", "connectivity", "", bytes_of(std::vector<std::int64_t>{0, 1, 2, 3}),
             "0 1 2 3") +
         tag("Int64", "offsets", "", bytes_of(std::vector<std::int64_t>{4}), "4") +
         "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

TEST_F(MeshFile, ReadsTextBase64AndCompressedVtp) {
  const auto size = [](const std::string& bytes) {
    return bytes_of(std::vector<std::uint64_t>{bytes.size()});
  };
  const auto expect = [](const TriangleMesh& mesh) {
    EXPECT_EQ(mesh.vertices.size(), 6U);
    EXPECT_EQ(mesh.vertices[5], (Vec3{1, 0, 2}));
    EXPECT_EQ(mesh.triangles,
              (std::vector<TriangleIndices>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}, {4, 1, 5}}));
  };
  expect(read("a.vtp", vtp("", "ascii", [](const auto&, const auto& text) { return text; })));
  expect(read("b.vtp", vtp("", "binary", [&](const auto& bytes, const auto&) {
                return base64(size(bytes) + bytes);
              })));
  expect(read(
      "c.vtp",
      vtp(" compressor=\"vtkZLibDataCompressor\"", "binary", [&](const auto& bytes, const auto&) {
        const std::string packed = zipped(bytes);
        return base64(bytes_of(std::vector<std::uint64_t>{1, bytes.size(), 0, packed.size()})) +
               base64(packed);
      })));
}

TEST_F(MeshFile, RejectsInvalidVtp) {
  const auto text = [](const auto&, const auto& numbers) { return numbers; };
  std::string other = vtp("", "ascii", text);
  other.replace(other.find("PolyData"), 8, "ImageDat");
  EXPECT_NE(complaint("a.vtp", other).find("instead of PolyData"), std::string::npos)
      << complaint("a.vtp", other);
  std::string beyond = vtp("", "ascii", text);
  beyond.replace(beyond.find("0 1 2 3"), 7, "0 1 2 6");
  EXPECT_NE(complaint("a.vtp", beyond).find("has the vertex 6 of 6"), std::string::npos);
  std::string many = vtp("", "ascii", text);
  many.replace(many.find("NumberOfPoints=\"6\""), 18, "NumberOfPoints=\"4000000000\"");
  EXPECT_NE(complaint("a.vtp", many).find("Cannot read"), std::string::npos);
}

// ---- 3MF

std::string model_with(const std::string& items, const std::string& more = "") {
  return "<?xml version=\"1.0\"?>" + more +
         "<m:model xmlns:m=\"x\"><m:object id=\"7\"><m:mesh><m:vertices><m:vertex x=\"1\" y=\"0\" "
         "z=\"0\"/><m:vertex x=\"0\" y=\"1e0\" z=\"0\"/><m:vertex x=\"0\" y=\"0\" "
         "z=\"1\"/></m:vertices>"
         "<m:triangles><m:triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"1\"/></m:triangles></m:mesh>"
         "</m:object><m:build>" +
         items + "</m:build></m:model>";
}

TEST(ThreeMfModel, PlacesItsItems) {
  std::vector<std::size_t> first;
  const TriangleMesh mesh = read_three_mf_model(
      model_with("<m:item objectid=\"7\"/><m:item objectid=\"7\" transform=\"-2 0 0 0 3 0 0 0 4 10 "
                 "20 30\"/>"),
      &first);
  EXPECT_EQ(first, (std::vector<std::size_t>{0, 1}));
  ASSERT_EQ(mesh.vertices.size(), 6U);
  EXPECT_EQ(mesh.vertices[3], (Vec3{8, 20, 30}));
  EXPECT_EQ(mesh.vertices[4], (Vec3{10, 23, 30}));
  // The mirrored one keeps its outside.
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{0, 1, 2}, {3, 5, 4}}));
}

TEST(ThreeMfModel, SaysWhatItDoesNotRead) {
  const auto problem = [](const std::string& model) -> std::string {
    try {
      (void)read_three_mf_model(model);
      return {};
    } catch (const MeshFileError& error) {
      return error.what();
    }
  };
  EXPECT_NE(problem(model_with("<m:item objectid=\"8\"/>")).find("object 8"), std::string::npos);
  EXPECT_NE(problem(model_with("<m:item/>")).find("<item> is incomplete"), std::string::npos);
  EXPECT_NE(problem(model_with("<m:item objectid=\"7\" p:path=\"/3D/Objects/z.model\"/>"))
                .find("in another model"),
            std::string::npos);
  EXPECT_NE(problem(model_with("<m:components/>")).find("composed of parts"), std::string::npos);
  EXPECT_NE(problem(model_with("<m:item objectid=\"7\"")).find("damaged"), std::string::npos);
  EXPECT_NE(problem(model_with("", "<!DOCTYPE m [<!ENTITY a \"b\">]>")).find("entities"),
            std::string::npos);
  EXPECT_THROW((void)three_mf_model("PK\3\4"), MeshFileError);
}

// A zip archive whose files are not compressed.
std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string bytes;
  std::string directory;
  const auto number = [](std::string& into, std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i) into += static_cast<char>(value >> (8 * i));
  };
  for (const auto& [name, content] : files) {
    const std::size_t place = bytes.size();
    std::string header;
    for (const int zero : {20, 0, 0, 0, 0}) number(header, static_cast<unsigned>(zero), 2);
    number(
        header,
        crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())),
        4);
    number(header, content.size(), 4);
    number(header, content.size(), 4);
    number(header, name.size(), 2);
    number(header, 0, 2);
    bytes += "PK\3\4" + header + name + content;
    directory += "PK\1\2";
    number(directory, 20, 2);
    directory += header + std::string(10, '\0');
    number(directory, place, 4);
    directory += name;
  }
  const std::size_t begin = bytes.size();
  bytes += directory + "PK\5\6" + std::string(4, '\0');
  number(bytes, files.size(), 2);
  number(bytes, files.size(), 2);
  number(bytes, directory.size(), 4);
  number(bytes, begin, 4);
  number(bytes, 0, 2);
  return bytes;
}

TEST_F(MeshFile, ReadsTheModelThatA3mfFileNames) {
  const std::string model = model_with("<m:item objectid=\"7\"/>");
  const auto relations = [](const std::string& target) {
    return "<Relationships><Relationship Target=\"/Metadata/plate.png\" "
           "Type=\"http://x/thumbnail\"/>"
           "<Relationship Target=\"" +
           target +
           "\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
           "</Relationships>";
  };
  EXPECT_EQ(read("a.3mf", stored_zip({{"_rels/.rels", relations("/model/part.xml")},
                                      {"3D/3dmodel.model", "not it"},
                                      {"Model/Part.xml", model}}))
                .triangles.size(),
            1U);
  EXPECT_EQ(read("a.3mf", stored_zip({{"_rels/.rels", relations("/3D/My%20part.model")},
                                      {"3D/My part.model", model}}))
                .triangles.size(),
            1U);
  EXPECT_EQ(read("a.3mf", stored_zip({{"3D/3dmodel.model", model}})).triangles.size(), 1U);
  EXPECT_NE(complaint("a.3mf", stored_zip({{"_rels/.rels", relations("/3D/none.model")},
                                           {"3D/3dmodel.model", model}}))
                .find("without the model '3D/none.model' that it names"),
            std::string::npos);
}

TEST_F(MeshFile, ConvertsTheUnitOfA3mfFile) {
  const PositionedMesh torus = positioned(surfaces::torus(5, 5, 4, 0.2, 1), Affine{});
  TriangleMesh mesh =
      read("a.3mf", mesh_file(torus, MeshFormat::k3mf, {.world = {.length_unit = "mm"}}));
  EXPECT_EQ(mesh.length_unit, "mm");
  const TriangleMesh as_written = mesh;
  EXPECT_TRUE(convert_to_unit(mesh, "").empty());
  EXPECT_TRUE(convert_to_unit(mesh, "mm").empty());
  EXPECT_EQ(mesh.vertices, as_written.vertices);
  const auto said = convert_to_unit(mesh, "µm");
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("is in mm, the volume in µm"), std::string::npos);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_EQ(mesh.vertices[i][0], 1000 * as_written.vertices[i][0]);
  }
  EXPECT_TRUE(convert_to_unit(mesh, "µm").empty());
  EXPECT_TRUE(read("b.3mf", mesh_file(torus, MeshFormat::k3mf)).length_unit.empty());
}

TEST(ThreeMfModel, HasUnitNameAndColorOfEachSurface) {
  const PositionedMesh closed = positioned(surfaces::torus(5, 5, 4, 0.2, 1), Affine{});
  PositionedMesh open = closed;
  open.triangles.pop_back();
  const std::array parts = {
      ScenePart{.name = {.text = "a & \"b\"", .color = 0x102030}, .mesh = &closed},
      ScenePart{.name = {.text = "open"}, .mesh = &open}};
  const std::string model =
      three_mf_model(three_mf_file(parts, {.length_unit = "µm"}, std::string(kMeshFileTitle)));
  for (const char* const wanted :
       {"unit=\"micron\"", "name=\"a &amp; &quot;b&quot;\" displaycolor=\"#102030\"",
        "type=\"model\" name=\"a", "type=\"surface\" name=\"open\""}) {
    EXPECT_NE(model.find(wanted), std::string::npos) << wanted;
  }
  const std::string other = three_mf_model(three_mf_file(parts, {.length_unit = "pixels"}, "t"));
  EXPECT_NE(other.find("length unit pixels"), std::string::npos);
  EXPECT_EQ(other.find("unit=\""), std::string::npos);
}

TEST(ThreeMfModel, HasOtherUnitsInOneOfItsOwn) {
  const PositionedMesh torus = positioned(surfaces::torus(5, 5, 4, 0.2, 1), Affine{});
  const std::array parts = {ScenePart{.name = {}, .mesh = &torus}};
  for (const auto& [unit, own, factor] : {std::tuple("nm", "µm", 1e-3),
                                          {"Å", "µm", 1e-4},
                                          {"dm", "mm", 100.0},
                                          {"km", "m", 1000.0}}) {
    TriangleMesh mesh =
        read_three_mf_model(three_mf_model(three_mf_file(parts, {.length_unit = unit}, "t")));
    EXPECT_EQ(mesh.length_unit, own);
    EXPECT_NEAR(mesh.vertices[3][0], factor * torus.positions[3][0], 1e-12 * factor);
    EXPECT_FALSE(convert_to_unit(mesh, unit).empty());
    EXPECT_NEAR(mesh.vertices[3][0], torus.positions[3][0], 1e-9);
  }
}

// ---- damage

TEST_F(MeshFile, RejectsOtherFilesByName) {
  EXPECT_NE(
      complaint("a.ply", "GIF89a").find("its format is unknown: it begins with neither 'ply'"),
      std::string::npos);
  EXPECT_NE(complaint("a.xyz", "0 0 0\n").find("a.xyz"), std::string::npos);
  EXPECT_THROW((void)read_mesh(folder_.path() / "missing.stl"), VolumeFileError);
  EXPECT_THROW((void)read_mesh(folder_.path()), VolumeFileError);
}

// Any bytes give either a mesh whose vertices exist or an error.
TEST_F(MeshFile, ReadsOrRejectsDamagedFiles) {
  std::mt19937 random(5);
  const LatticeMesh torus = surfaces::torus(3, 6, 5, 0.2, 1);
  PositionedMesh mesh = positioned(torus, {});
  std::vector<std::pair<std::string, std::string>> files = {
      {"n.glb", nested_glb(R"([{"mesh":0}])")},
      {"l.glb", lattice_glb(torus, {.exponent = 6}, {1, 1, 1})},
      {"t.vtp", vtp("", "ascii", [](const auto&, const auto& text) { return text; })}};
  for (const auto& [name, format] : {std::pair("a.ply", MeshFormat::kPly),
                                     {"a.stl", MeshFormat::kStl},
                                     {"a.obj", MeshFormat::kObj},
                                     {"a.glb", MeshFormat::kGlb},
                                     {"a.vtp", MeshFormat::kVtp},
                                     {"a.3mf", MeshFormat::k3mf},
                                     {"a.drc", MeshFormat::kDrc}}) {
    files.emplace_back(name, mesh_file(mesh, format));
  }
  int refused = 0;
  for (const auto& [name, whole] : files) {
    for (int i = 0; i < 60; ++i) {
      std::string bytes = whole;
      if (i % 2 == 0) bytes.resize(random() % bytes.size());
      for (int j = 0; j < i % 4 && !bytes.empty(); ++j) {
        bytes[random() % std::min<std::size_t>(bytes.size(), i % 3 == 0 ? 200 : bytes.size())] =
            static_cast<char>(random());
      }
      try {
        const TriangleMesh found = read_mesh_here(folder_.file(name, bytes));
        for (const TriangleIndices& t : found.triangles) {
          for (const std::uint32_t corner : t) ASSERT_LT(corner, found.vertices.size());
        }
      } catch (const VolumeFileError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace multitetra

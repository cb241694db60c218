#include "common/wire/mesh_files.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

#include <draco/compression/decode.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/surfaces.hpp"

namespace multitetra {
namespace {

using Corners = std::array<Vec3, 3>;

// A mesh in world coordinates far from the origin, where rounding is noticeable.
PositionedMesh world_mesh() {
  const Affine to_world{.columns = {Vec3{0.7, 0, 0}, Vec3{0, 1.3, 0.1}, Vec3{0, 0, 2}},
                        .translation = {-500.25, 1000, 3}};
  PositionedMesh mesh = positioned(surfaces::torus(5, 12, 8, 0.2, 1), to_world);
  for (Vec3& position : mesh.positions) {  // Numbers that floats hold.
    for (double& coordinate : position) coordinate = static_cast<double>(float(coordinate));
  }
  return mesh;
}

// The positions of the triangles' corners, in file order.
std::vector<Corners> corners(const PositionedMesh& mesh) {
  std::vector<Corners> result;
  for (const TriangleIndices& t : mesh.triangles) {
    result.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  }
  return result;
}

template <typename T>
T take(std::string_view& bytes) {
  T value;
  EXPECT_GE(bytes.size(), sizeof(T));
  std::memcpy(&value, bytes.data(), sizeof(T));
  bytes.remove_prefix(sizeof(T));
  return value;
}

template <typename T>
std::vector<T> take_all(std::string_view bytes, std::size_t offset, std::size_t count) {
  bytes = bytes.substr(offset);
  std::vector<T> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(take<T>(bytes));
  return values;
}

// ---- minimal readers of the formats

PositionedMesh read_ply(std::string_view file) {
  const std::size_t end = file.find("end_header\n") + 11;
  std::istringstream header{std::string(file.substr(0, end))};
  std::string line;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::getline(header, line);
  EXPECT_EQ(line, "ply");
  std::getline(header, line);
  EXPECT_EQ(line, "format binary_little_endian 1.0");
  while (std::getline(header, line)) {
    if (line.starts_with("element vertex ")) vertices = std::stoul(line.substr(15));
    if (line.starts_with("element face ")) faces = std::stoul(line.substr(13));
  }
  PositionedMesh mesh;
  std::string_view body = file.substr(end);
  const bool has_normals = header.str().find(
                               "property float z\nproperty float nx\nproperty float ny\n"
                               "property float nz\n") != std::string::npos;
  for (std::size_t i = 0; i < vertices; ++i) {
    mesh.positions.push_back(vec3(take<std::array<float, 3>>(body)));
    if (has_normals) mesh.normals.push_back(take<UnitVector>(body));
  }
  for (std::size_t i = 0; i < faces; ++i) {
    EXPECT_EQ(take<std::uint8_t>(body), 3);
    mesh.triangles.push_back(take<TriangleIndices>(body));
  }
  EXPECT_TRUE(body.empty());
  return mesh;
}

PositionedMesh read_obj(const std::string& file) {
  std::istringstream lines(file);
  PositionedMesh mesh;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(1));
    if (line.starts_with("vn ")) {
      std::istringstream numbers(line.substr(2));
      UnitVector n{};
      EXPECT_TRUE(numbers >> n[0] >> n[1] >> n[2]) << line;
      mesh.normals.push_back(n);
    } else if (line.starts_with("f ") && line.find("//") != std::string::npos) {
      TriangleIndices t{};
      TriangleIndices n{};
      char slash = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_TRUE(words >> t[i] >> slash >> slash >> n[i]) << line;
      }
      EXPECT_EQ(t, n) << line;
      mesh.triangles.push_back({t[0] - 1, t[1] - 1, t[2] - 1});
    } else if (line.starts_with("v ")) {
      std::array<float, 3> p{};
      EXPECT_TRUE(words >> p[0] >> p[1] >> p[2]) << line;
      mesh.positions.push_back(vec3(p));
    } else if (line.starts_with("f ")) {
      TriangleIndices t{};
      EXPECT_TRUE(words >> t[0] >> t[1] >> t[2]) << line;
      mesh.triangles.push_back({t[0] - 1, t[1] - 1, t[2] - 1});
    }
  }
  return mesh;
}

struct Glb {
  nlohmann::json json;
  std::string_view binary;
};

Glb read_glb(std::string_view file) {
  EXPECT_EQ(file.size() % 4, 0U);
  std::string_view rest = file;
  EXPECT_EQ(take<std::uint32_t>(rest), 0x46546C67U);
  EXPECT_EQ(take<std::uint32_t>(rest), 2U);
  EXPECT_EQ(take<std::uint32_t>(rest), file.size());
  const auto json_bytes = take<std::uint32_t>(rest);
  EXPECT_EQ(take<std::uint32_t>(rest), 0x4E4F534AU);
  Glb glb{nlohmann::json::parse(rest.substr(0, json_bytes)), {}};
  rest.remove_prefix(json_bytes);
  if (rest.empty()) return glb;
  const auto binary_bytes = take<std::uint32_t>(rest);
  EXPECT_EQ(take<std::uint32_t>(rest), 0x004E4942U);
  EXPECT_EQ(rest.size(), binary_bytes);
  glb.binary = rest;
  return glb;
}

// The mesh with normals that do not match its triangles.
PositionedMesh shaded_mesh() {
  PositionedMesh mesh = world_mesh();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto angle = static_cast<float>(i);
    mesh.normals.push_back({std::cos(angle), 0, std::sin(angle)});
  }
  return mesh;
}

// ---- round trips

TEST(MeshFile, WritesTheNormalsOfTheMesh) {
  const PositionedMesh mesh = shaded_mesh();
  for (const PositionedMesh& read :
       {read_ply(mesh_file(mesh, MeshFormat::kPly)), read_obj(mesh_file(mesh, MeshFormat::kObj))}) {
    EXPECT_EQ(read.positions, mesh.positions);
    EXPECT_EQ(read.triangles, mesh.triangles);
    EXPECT_EQ(read.normals, mesh.normals);
  }
  const std::string glb = mesh_file(mesh, MeshFormat::kGlb);
  EXPECT_EQ((take_all<UnitVector>(read_glb(glb).binary, 12 * mesh.positions.size(),
                                  mesh.positions.size())),
            mesh.normals);
  const std::string drc = mesh_file(mesh, MeshFormat::kDrc);
  draco::DecoderBuffer buffer;
  buffer.Init(drc.data(), drc.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_NE(decoded.value()->GetNamedAttribute(draco::GeometryAttribute::NORMAL), nullptr);
}

TEST(MeshFile, RoundTripsPly) {
  const PositionedMesh mesh = world_mesh();
  const PositionedMesh read = read_ply(mesh_file(mesh, MeshFormat::kPly));
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.triangles, mesh.triangles);
}

TEST(MeshFile, RoundTripsObjExactly) {
  const PositionedMesh mesh = world_mesh();
  const PositionedMesh read = read_obj(mesh_file(mesh, MeshFormat::kObj));
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.triangles, mesh.triangles);
}

TEST(MeshFile, WritesCornersAndOutwardNormalsAsStl) {
  const PositionedMesh mesh = world_mesh();
  const std::string file = mesh_file(mesh, MeshFormat::kStl);
  EXPECT_FALSE(file.starts_with("solid")) << "would be taken for a text file";
  std::string_view rest = std::string_view(file).substr(80);
  ASSERT_EQ(take<std::uint32_t>(rest), mesh.triangles.size());
  for (const Corners& expected : corners(mesh)) {
    const auto normal = take<std::array<float, 3>>(rest);
    for (const Vec3& corner : expected) {
      EXPECT_EQ(vec3(take<std::array<float, 3>>(rest)), corner);
    }
    EXPECT_EQ(take<std::uint16_t>(rest), 0);
    const auto edge = [&](std::size_t to, std::size_t axis) {
      return static_cast<double>(expected[to][axis] - expected[0][axis]);
    };
    double square = 0;
    double volume = 0;  // normal . (edge 1 x edge 2): positive if right-handed.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t a = (axis + 1) % 3;
      const std::size_t b = (axis + 2) % 3;
      square += static_cast<double>(normal[axis]) * static_cast<double>(normal[axis]);
      volume +=
          static_cast<double>(normal[axis]) * (edge(1, a) * edge(2, b) - edge(1, b) * edge(2, a));
    }
    EXPECT_NEAR(square, 1, 1e-5);
    EXPECT_GT(volume, 0);
  }
  EXPECT_TRUE(rest.empty());
}

TEST(MeshFile, WritesTheMeshAndItsBoundsAsGlb) {
  const PositionedMesh mesh = world_mesh();
  const std::string file = mesh_file(mesh, MeshFormat::kGlb);
  const Glb glb = read_glb(file);
  const nlohmann::json& primitive = glb.json.at("meshes").at(0).at("primitives").at(0);
  const auto accessor = [&](const nlohmann::json& index) {
    return glb.json.at("accessors").at(index.get<std::size_t>());
  };
  const auto offset = [&](const nlohmann::json& of) {
    return glb.json.at("bufferViews")
        .at(of.at("bufferView").get<std::size_t>())
        .at("byteOffset")
        .get<std::size_t>();
  };
  const nlohmann::json position = accessor(primitive.at("attributes").at("POSITION"));
  const nlohmann::json indices = accessor(primitive.at("indices"));
  EXPECT_EQ(glb.json.at("buffers").at(0).at("byteLength"), glb.binary.size());
  std::vector<Vec3> found;
  for (const auto& place :
       take_all<std::array<float, 3>>(glb.binary, offset(position), position.at("count"))) {
    found.push_back(vec3(place));
  }
  EXPECT_EQ(found, mesh.positions);
  EXPECT_EQ(indices.at("componentType"), 5125);
  EXPECT_EQ(indices.at("count"), 3 * mesh.triangles.size());
  EXPECT_EQ((take_all<TriangleIndices>(glb.binary, offset(indices), mesh.triangles.size())),
            mesh.triangles);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [low, high] =
        std::minmax_element(mesh.positions.begin(), mesh.positions.end(),
                            [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; });
    EXPECT_EQ(position.at("min").at(axis).get<double>(), (*low)[axis]);
    EXPECT_EQ(position.at("max").at(axis).get<double>(), (*high)[axis]);
  }
}

// EXT_mesh_manifold: positions and indices that bound a solid; of closed surfaces only.
TEST(MeshFile, MarksClosedSurfacesAsManifoldInGlb) {
  const PositionedMesh torus = world_mesh();
  PositionedMesh open = torus;
  open.triangles.pop_back();
  const nlohmann::json closed = read_glb(mesh_file(torus, MeshFormat::kGlb)).json;
  EXPECT_EQ(closed.at("extensionsUsed"), nlohmann::json::array({"EXT_mesh_manifold"}));
  const nlohmann::json& mesh = closed.at("meshes").at(0);
  const nlohmann::json& solid =
      mesh.at("extensions").at("EXT_mesh_manifold").at("manifoldPrimitive");
  const nlohmann::json& drawn = mesh.at("primitives").at(0);
  EXPECT_EQ(solid.at("attributes"),
            (nlohmann::json{{"POSITION", drawn.at("attributes").at("POSITION")}}));
  EXPECT_EQ(solid.at("indices"), drawn.at("indices"));
  EXPECT_EQ(solid.at("mode"), 4);
  const nlohmann::json without = read_glb(mesh_file(open, MeshFormat::kGlb)).json;
  EXPECT_FALSE(without.contains("extensionsUsed") &&
               without.at("extensionsUsed").dump().find("EXT_mesh_manifold") != std::string::npos);
  EXPECT_FALSE(without.at("meshes").at(0).contains("extensions"));
}

TEST(MeshFile, WritesUnitAndSpaceOfTheWorldAsGlb) {
  const auto asset_of = [](const PhysicalMeaning& world) {
    return read_glb(mesh_file(world_mesh(), MeshFormat::kGlb, {.world = world})).json.at("asset");
  };
  EXPECT_FALSE(asset_of({}).contains("extras"));
  EXPECT_EQ(
      asset_of({.space = WorldSpace::kRas, .length_unit = "µm", .value_unit = "HU"})["extras"],
      (nlohmann::json{{"length_unit", "µm"}, {"space", "RAS"}}));
}

TEST(MeshFile, NamesTheSurfaceAndItsLabel) {
  const MeshFileFacts liver{.name = {.text = "the liver", .label = 17}, .lattice = 5};
  const std::string ply = mesh_file(world_mesh(), MeshFormat::kPly, liver);
  EXPECT_NE(ply.find(", lattice 5, label 17\ncomment name the liver\nelement"), std::string::npos);
  EXPECT_EQ(read_ply(ply).triangles, world_mesh().triangles);
  const std::string obj = mesh_file(world_mesh(), MeshFormat::kObj, liver);
  EXPECT_NE(obj.find(", lattice 5, label 17\no the liver\nv "), std::string::npos);
  const Glb glb = read_glb(mesh_file(world_mesh(), MeshFormat::kGlb, liver));
  const nlohmann::json& node = glb.json.at("nodes").at(0);
  EXPECT_EQ(node.at("name"), "the liver");
  EXPECT_EQ(node.at("extras"), (nlohmann::json{{"label", 17}}));
}

TEST(MeshFile, WritesValidGltfWithTheUpAxisConverted) {
  const Glb glb = read_glb(mesh_file(world_mesh(), MeshFormat::kGlb));
  EXPECT_EQ(glb.json.at("asset").at("version"), "2.0");
  EXPECT_EQ(glb.json.at("scenes").at(0).at("nodes"), nlohmann::json::array({0}));
  EXPECT_EQ(glb.json.at("scene"), 0);
  const auto matrix = glb.json.at("nodes").at(0).at("matrix").get<std::vector<double>>();
  ASSERT_EQ(matrix.size(), 16U);
  // The third column, the image of z, is y; the image of y is -z.
  EXPECT_EQ((std::vector<double>{matrix[8], matrix[9], matrix[10]}),
            (std::vector<double>{0, 1, 0}));
  EXPECT_EQ((std::vector<double>{matrix[4], matrix[5], matrix[6]}),
            (std::vector<double>{0, 0, -1}));
  EXPECT_EQ(glb.json.at("materials").at(0).at("doubleSided"), true);
  EXPECT_TRUE(glb.json.at("materials").at(0).at("pbrMetallicRoughness").is_object());
  EXPECT_TRUE(glb.json.at("buffers").is_array());
  EXPECT_EQ(glb.json.at("bufferViews").size(), 3U);
  EXPECT_EQ(glb.json.at("meshes").at(0).at("primitives").at(0).at("material"), 0);
}

TEST(MeshFile, WritesOutwardUnitNormalsAsGlb) {
  const LatticePoint center = surfaces::center(5);
  const PositionedMesh mesh =
      positioned(index_triangles(surfaces::octahedron(center, 64), 5), Affine{});
  const std::string file = mesh_file(mesh, MeshFormat::kGlb);
  const Glb glb = read_glb(file);
  const auto normals =
      take_all<std::array<float, 3>>(glb.binary, 12 * mesh.positions.size(), mesh.positions.size());
  const Vec3 middle = grid_coordinates(center, 5);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // An octahedron's vertex lies two grid steps from its middle, along its normal.
      EXPECT_NEAR(static_cast<double>(normals[i][axis]),
                  (mesh.positions[i][axis] - middle[axis]) / 2, 1e-6);
    }
  }
}

TEST(MeshFile, LargeTrianglesDoNotDominateNormalsOfGlb) {
  // The top of a ball with one large triangle and three small ones around it.
  const auto on_ball = [](double x, double y) {
    return Vec3{x, y, std::sqrt(250000 - x * x - y * y)};
  };
  const PositionedMesh mesh = {.positions = {on_ball(0, 0), on_ball(100, 0), on_ball(0, 100),
                                             on_ball(-40, 0), on_ball(0, -40)},
                               .triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}}};
  const std::string file = mesh_file(mesh, MeshFormat::kGlb);
  const auto normals = take_all<std::array<float, 3>>(read_glb(file).binary, 12 * 5, 5);
  // 0.086 with weights by area.
  EXPECT_LT(std::hypot(normals[0][0], normals[0][1]), 0.05);
}

TEST(MeshFile, KeepsDracoPositionsWithinHalfAQuantizationStep) {
  const PositionedMesh mesh = world_mesh();
  const std::string file = mesh_file(mesh, MeshFormat::kDrc);
  draco::DecoderBuffer buffer;
  buffer.Init(file.data(), file.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_EQ(decoded.value()->num_faces(), mesh.triangles.size());
  const draco::PointAttribute* attribute =
      decoded.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  ASSERT_EQ(attribute->size(), mesh.positions.size());
  for (draco::AttributeValueIndex at(0); at < static_cast<std::uint32_t>(attribute->size()); ++at) {
    std::array<float, 3> found{};
    attribute->GetValue(at, &found);
    double nearest = 1e9;
    for (const auto& p : mesh.positions) {
      const Vec3 off = difference(p, vec3(found));
      nearest = std::min(nearest, std::max({std::abs(off[0]), std::abs(off[1]), std::abs(off[2])}));
    }
    // Half of 64 / 2^20, plus the rounding of floats near 1000.
    EXPECT_LT(nearest, 32.0 / (1 << 20) + 1000.0 / (1 << 23));
  }
}

TEST(MeshFile, WritesAnEmptyMesh) {
  const PositionedMesh empty;
  EXPECT_EQ(read_ply(mesh_file(empty, MeshFormat::kPly)).triangles.size(), 0U);
  EXPECT_EQ(read_obj(mesh_file(empty, MeshFormat::kObj)).triangles.size(), 0U);
  EXPECT_EQ(mesh_file(empty, MeshFormat::kStl).size(), 84U);
  const Glb glb = read_glb(mesh_file(empty, MeshFormat::kGlb));
  EXPECT_FALSE(glb.json.contains("meshes"));
  EXPECT_EQ(glb.json.at("scenes").at(0),
            nlohmann::json::object());  // glTF forbids empty node lists.
  EXPECT_TRUE(mesh_file(empty, MeshFormat::kDrc).empty());
}

// ---- names and disk

TEST(MeshFormat, IsFoundBySuffixInAnyCase) {
  EXPECT_EQ(mesh_format_from(".PLY"), MeshFormat::kPly);
  EXPECT_EQ(mesh_format_from("stl"), MeshFormat::kStl);
  EXPECT_EQ(mesh_format_from(".obj"), MeshFormat::kObj);
  EXPECT_EQ(mesh_format_from("Glb"), MeshFormat::kGlb);
  EXPECT_EQ(mesh_format_from(".drc"), MeshFormat::kDrc);
  EXPECT_EQ(mesh_format_from(".gltf"), std::nullopt);
  EXPECT_EQ(mesh_format_from(""), std::nullopt);
  EXPECT_EQ(media_type(MeshFormat::kGlb), "model/gltf-binary");
}

std::vector<std::string> entries(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

TEST(WriteFile, ReplacesTheWholeFileAndLeavesNoTemporaries) {
  const std::filesystem::path folder = ::testing::TempDir() + "multitetra_write_file";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  write_file(folder / "mesh.ply", std::string(1000, 'a'));
  write_file(folder / "mesh.ply", "short");
  std::ifstream file(folder / "mesh.ply");
  std::string content;
  std::getline(file, content);
  EXPECT_EQ(content, "short");
  EXPECT_EQ(entries(folder), std::vector<std::string>{"mesh.ply"});
}

TEST(WriteFile, NamesThePathAndTheReasonOfAFailure) {
  const std::filesystem::path folder = ::testing::TempDir() + "multitetra_write_file_fails";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "taken.ply" / "inside");
  for (const auto& path : {folder / "absent" / "mesh.ply", folder / "taken.ply"}) {
    try {
      write_file(path, "x");
      FAIL() << path;
    } catch (const std::system_error& error) {
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
      EXPECT_NE(error.code().value(), 0);
    }
  }
  EXPECT_EQ(entries(folder), std::vector<std::string>{"taken.ply"});
}

}  // namespace
}  // namespace multitetra

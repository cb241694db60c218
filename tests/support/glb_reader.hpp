// Reads binary glTF with Draco compression.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/mesh/mesh.hpp"

namespace multitetra::testing {

struct ReadGlb {
  nlohmann::json json;
  std::string binary;
};

inline ReadGlb read_glb(std::string_view file) {
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    if (at + 4 <= file.size()) std::memcpy(&value, file.data() + at, 4);
    return value;
  };
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(number(8), file.size());
  const std::uint32_t length = number(12);
  ReadGlb glb{.json = nlohmann::json::parse(file.substr(20, length)), .binary = {}};
  if (file.size() > 20 + length) glb.binary = file.substr(28 + length, number(20 + length));
  return glb;
}

// Returns the only mesh in lattice coordinates, welded; empty if the scene has no mesh.
inline LatticeMesh mesh_in(const ReadGlb& glb, int resolution = kDefaultLatticeResolution) {
  LatticeMesh split{.resolution = resolution, .vertices = {}, .triangles = {}};
  if (!glb.json.contains("meshes")) return split;
  const auto& primitive = glb.json["meshes"][0]["primitives"][0];
  const auto& extension = primitive["extensions"]["KHR_draco_mesh_compression"];
  draco::DecoderBuffer buffer;
  buffer.Init(glb.binary.data(), glb.json["bufferViews"][0]["byteLength"].get<std::size_t>());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  EXPECT_TRUE(decoded.ok());
  const draco::Mesh& mesh = *decoded.value();
  const auto& accessors = glb.json["accessors"];
  EXPECT_EQ(accessors[1]["count"], mesh.num_points());
  EXPECT_EQ(accessors[0]["count"], 3 * mesh.num_faces());
  const draco::PointAttribute* position =
      mesh.GetAttributeByUniqueId(extension["attributes"]["POSITION"].get<std::uint32_t>());
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    std::array<float, 3> at{};
    position->GetMappedValue(point, at.data());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(at[axis], std::round(at[axis]));
      EXPECT_GE(at[axis], accessors[1]["min"][axis].get<float>());
      EXPECT_LE(at[axis], accessors[1]["max"][axis].get<float>());
    }
    split.vertices.push_back({static_cast<std::int32_t>(at[0]), static_cast<std::int32_t>(at[1]),
                              static_cast<std::int32_t>(at[2])});
  }
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
    const draco::Mesh::Face& corners = mesh.face(face);
    split.triangles.push_back({corners[0].value(), corners[1].value(), corners[2].value()});
  }
  return weld(std::span(&split, 1), resolution);
}

}  // namespace multitetra::testing

#include "tests/bench/mesh_codecs.hpp"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "common/wire/tile.hpp"

#include <meshoptimizer.h>

namespace multitetra {

EncodedMesh encoded_by_draco(const PlainMesh& mesh) {
  if (mesh.triangles.empty()) return {.bytes = 0, .decode = [] {}};
  PositionedMesh placed{.positions = {}, .triangles = mesh.triangles};
  for (const auto& position : mesh.positions) placed.positions.push_back(vec3(position));
  const auto bytes = std::make_shared<const std::string>(encode_draco_file(placed, kPeerBits));
  return {.bytes = bytes->size(), .decode = [bytes] {
            draco::DecoderBuffer buffer;
            buffer.Init(bytes->data(), bytes->size());
            draco::Decoder decoder;
            if (!decoder.DecodeMeshFromBuffer(&buffer).ok()) {
              throw std::logic_error("Draco cannot decode its own bytes");
            }
          }};
}

namespace {

using Bytes = std::vector<unsigned char>;

Bytes compressed(const Bytes& bytes) {
  Bytes result(ZSTD_compressBound(bytes.size()));
  result.resize(
      ZSTD_compress(result.data(), result.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT));
  return result;
}

Bytes decompressed(const Bytes& bytes, std::size_t size) {
  Bytes result(size);
  if (ZSTD_decompress(result.data(), size, bytes.data(), bytes.size()) != size) {
    throw std::logic_error("zstd cannot decompress its own bytes");
  }
  return result;
}

// Padded to a multiple of four bytes, which the vertex codec requires.
struct QuantizedPosition {
  std::uint16_t x, y, z, unused;
};

struct Quantization {
  std::array<float, 3> low = {};
  float step = 1;
};

Quantization quantization_of(const PlainMesh& mesh) {
  Quantization form{.low = mesh.positions.front()};
  std::array<float, 3> high = form.low;
  for (const auto& p : mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      form.low[axis] = std::min(form.low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  float extent = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent = std::max(extent, high[axis] - form.low[axis]);
  }
  form.step = extent / ((1 << kPeerBits) - 1);
  return form;
}

std::vector<QuantizedPosition> quantized(const PlainMesh& mesh, const Quantization& form) {
  std::vector<QuantizedPosition> result;
  result.reserve(mesh.positions.size());
  for (const auto& p : mesh.positions) {
    const auto code = [&](std::size_t axis) {
      return static_cast<std::uint16_t>(std::lround((p[axis] - form.low[axis]) / form.step));
    };
    result.push_back({code(0), code(1), code(2), 0});
  }
  return result;
}

// The transferred data, and what the receiver must know to decode it.
struct MeshoptFile {
  Bytes indices;
  Bytes vertices;
  std::size_t index_bytes = 0;  // Before zstd.
  std::size_t vertex_bytes = 0;
  std::size_t index_count = 0;
  std::size_t vertex_count = 0;
  Quantization form;
};

PlainMesh decoded(const MeshoptFile& file) {
  const Bytes indices = decompressed(file.indices, file.index_bytes);
  const Bytes vertices = decompressed(file.vertices, file.vertex_bytes);
  PlainMesh mesh;
  mesh.triangles.resize(file.index_count / 3);
  std::vector<QuantizedPosition> codes(file.vertex_count);
  if (meshopt_decodeIndexBuffer(mesh.triangles.data(), file.index_count, sizeof(std::uint32_t),
                                indices.data(), indices.size()) != 0 ||
      meshopt_decodeVertexBuffer(codes.data(), codes.size(), sizeof(QuantizedPosition),
                                 vertices.data(), vertices.size()) != 0) {
    throw std::logic_error("meshoptimizer cannot decode its own bytes");
  }
  mesh.positions.reserve(codes.size());
  const auto& [low, step] = file.form;
  for (const QuantizedPosition& q : codes) {
    mesh.positions.push_back({low[0] + step * q.x, low[1] + step * q.y, low[2] + step * q.z});
  }
  return mesh;
}

}  // namespace

std::string meshoptimizer_version() {
  return "meshoptimizer " + std::to_string(MESHOPTIMIZER_VERSION);
}

EncodedMesh encoded_by_meshoptimizer(const PlainMesh& mesh) {
  if (mesh.triangles.empty()) return {.bytes = 0, .decode = [] {}};
  std::vector<unsigned> indices(3 * mesh.triangles.size());
  const unsigned* const given = mesh.triangles.front().data();
  meshopt_optimizeVertexCache(indices.data(), given, indices.size(), mesh.positions.size());
  const Quantization form = quantization_of(mesh);
  std::vector<QuantizedPosition> vertices = quantized(mesh, form);
  vertices.resize(meshopt_optimizeVertexFetch(vertices.data(), indices.data(), indices.size(),
                                              vertices.data(), vertices.size(),
                                              sizeof(QuantizedPosition)));
  Bytes index_bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices.size()));
  index_bytes.resize(meshopt_encodeIndexBuffer(index_bytes.data(), index_bytes.size(),
                                               indices.data(), indices.size()));
  Bytes vertex_bytes(meshopt_encodeVertexBufferBound(vertices.size(), sizeof(QuantizedPosition)));
  vertex_bytes.resize(meshopt_encodeVertexBuffer(vertex_bytes.data(), vertex_bytes.size(),
                                                 vertices.data(), vertices.size(),
                                                 sizeof(QuantizedPosition)));
  const auto file =
      std::make_shared<const MeshoptFile>(MeshoptFile{.indices = compressed(index_bytes),
                                                      .vertices = compressed(vertex_bytes),
                                                      .index_bytes = index_bytes.size(),
                                                      .vertex_bytes = vertex_bytes.size(),
                                                      .index_count = indices.size(),
                                                      .vertex_count = vertices.size(),
                                                      .form = form});
  return {.bytes = file->indices.size() + file->vertices.size(), .decode = [file] {
            if (decoded(*file).triangles.empty()) throw std::logic_error("nothing was decoded");
          }};
}

PlainMesh simplified_by_meshoptimizer(const PlainMesh& mesh, double error) {
  if (mesh.triangles.empty()) return mesh;
  std::vector<unsigned> indices;
  for (const auto& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const float* const positions = mesh.positions.front().data();
  const std::size_t stride = sizeof(mesh.positions.front());
  const float scale = meshopt_simplifyScale(positions, mesh.positions.size(), stride);
  std::vector<unsigned> left(indices.size());
  left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(), positions,
                               mesh.positions.size(), stride, 0, static_cast<float>(error) / scale,
                               0, nullptr));
  PlainMesh result;  // Keeps only used vertices.
  std::vector<std::uint32_t> number(mesh.positions.size(), ~0U);
  for (std::size_t i = 0; i < left.size(); i += 3) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t j = 0; j < 3; ++j) {
      std::uint32_t& at = number[left[i + j]];
      if (at == ~0U) {
        at = static_cast<std::uint32_t>(result.positions.size());
        result.positions.push_back(mesh.positions[left[i + j]]);
      }
      triangle[j] = at;
    }
    result.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace multitetra

#include "server/tilesets/neuroglancer.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <tuple>
#include <vector>

#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/wire/draco_primitive.hpp"
#include "server/tilesets/detail/metres.hpp"
#include "server/tilesets/neuroglancer_image.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVertexBits = 16;
constexpr std::int64_t kLastStep = (1 << kVertexBits) - 1;

void append_u32(std::string& bytes, std::uint32_t value) {
  for (int byte = 0; byte < 4; ++byte) {
    bytes.push_back(static_cast<char>(value >> (8 * byte) & 0xFF));
  }
}
void append_u64(std::string& bytes, std::uint64_t value) {
  append_u32(bytes, static_cast<std::uint32_t>(value));
  append_u32(bytes, static_cast<std::uint32_t>(value >> 32));
}
void append_f32(std::string& bytes, double value) {
  append_u32(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

// Returns whether a precedes b in Morton order (bits of x, y and z interleaved, x lowest). The axis
// with the highest differing bit decides.
bool comes_before(const OctreeCube& a, const OctreeCube& b) {
  const auto differing = [](std::int32_t p, std::int32_t q) {
    return static_cast<std::uint32_t>(p ^ q);
  };
  const auto has_lower_top = [](std::uint32_t p, std::uint32_t q) { return p < q && p < (p ^ q); };
  std::tuple<std::uint32_t, std::int32_t, std::int32_t> top = {differing(a.z, b.z), a.z, b.z};
  for (const auto& [p, q] : {std::pair{a.y, b.y}, std::pair{a.x, b.x}}) {
    if (has_lower_top(std::get<0>(top), differing(p, q))) top = {differing(p, q), p, q};
  }
  return std::get<1>(top) < std::get<2>(top);
}

}  // namespace

std::uint64_t segment_of(double isovalue) {
  return std::bit_cast<std::uint64_t>(isovalue == 0 ? -0.0 : isovalue);
}

std::optional<double> isovalue_of_segment(std::string_view segment) {
  const auto bits = parse_number<std::uint64_t>(segment);
  if (!bits) return std::nullopt;
  const auto isovalue = std::bit_cast<double>(*bits);
  if (!std::isfinite(isovalue)) return std::nullopt;
  return isovalue == 0 ? 0.0 : isovalue;
}

std::string mesh_info_json(const DatasetInfo& dataset, MeshLayout layout) {
  const Affine place = manifest_to_image(dataset);
  Json transform = Json::array();  // Three rows of four numbers.
  for (std::size_t row = 0; row < 3; ++row) {
    for (const Vec3& column : place.columns) transform.push_back(column[row]);
    transform.push_back(place.translation[row]);
  }
  Json info = {{"@type", "neuroglancer_multilod_draco"},
               {"vertex_quantization_bits", kVertexBits},
               {"transform", std::move(transform)},
               {"lod_scale_multiplier", 1},
               {"segment_properties", "segment_properties"}};
  if (layout == MeshLayout::kShards) {
    info["sharding"] = {{"@type", "neuroglancer_uint64_sharded_v1"},
                        {"preshift_bits", 0},
                        {"hash", "identity"},
                        {"minishard_bits", 0},
                        {"shard_bits", 0},
                        {"minishard_index_encoding", "raw"},
                        {"data_encoding", "raw"}};
  }
  return json_text(info) + "\n";
}

std::string segment_properties_json(const DatasetInfo& info) {
  Json ids = Json::array();
  Json labels = Json::array();
  for (const double isovalue : info.suggested_isovalues) {
    ids.push_back(std::to_string(segment_of(isovalue)));
    std::string label = shortest_text(isovalue);
    if (!info.meaning.value_unit.empty()) label += " " + info.meaning.value_unit;
    labels.push_back(std::move(label));
  }
  const Json properties = {
      {"@type", "neuroglancer_segment_properties"},
      {"inline",
       {{"ids", std::move(ids)},
        {"properties",
         Json::array({{{"id", "label"}, {"type", "label"}, {"values", std::move(labels)}}})}}}};
  return json_text(properties) + "\n";
}

std::string mesh_fragment(const LatticeMesh& mesh, const OctreeCube& cell) {
  const std::int64_t side = std::int64_t{cell.side()} << mesh.resolution;
  // Rounds to nearest, so that a point between two octants lies on the border of both.
  const auto quantized = [side](std::int32_t at, std::int32_t position) {
    const std::int64_t local = at - position * side;
    return static_cast<std::int32_t>((2 * local * kLastStep + side) / (2 * side));
  };
  std::vector<std::array<std::int32_t, 3>> positions;
  positions.reserve(mesh.vertices.size());
  for (const LatticePoint& p : mesh.vertices) {
    positions.push_back({quantized(p.x, cell.x), quantized(p.y, cell.y), quantized(p.z, cell.z)});
  }
  std::vector<TriangleIndices> triangles;  // Degenerates occur only if the lattice is finer.
  for (const TriangleIndices& t : mesh.triangles) {
    const auto& a = positions[t[0]];
    const auto& b = positions[t[1]];
    const auto& c = positions[t[2]];
    if (a != b && b != c && c != a) triangles.push_back(t);
  }
  return triangles.empty() ? std::string() : encode_draco_integers(positions, triangles);
}

MeshFiles mesh_files_of(const Tileset& tileset, const MeshFragments& fragments) {
  const DatasetInfo& info = tileset.info();
  const double nanometres = 1e9 * metres_a_unit(info);
  const int leaf = tileset.leaf_exponent();
  const int levels = info.grid_exponent - leaf + 1;
  std::vector<std::vector<OctreeCube>> cells(static_cast<std::size_t>(levels));
  for (const auto& [cell, bytes] : fragments) {
    cells[static_cast<std::size_t>(cell.exponent - leaf)].push_back(cell);
  }
  MeshFiles files;
  std::string& manifest = files.manifest;
  for (const double step : info.spacing) append_f32(manifest, step * nanometres * (1 << leaf));
  for (const double step : info.spacing) {
    append_f32(manifest, (0.5 - info.margin) * step * nanometres);
  }
  append_u32(manifest, static_cast<std::uint32_t>(levels));
  const double diagonal = longest_cell_diagonal(info);
  for (int exponent = leaf; exponent < leaf + levels; ++exponent) {
    const double rounding = diagonal * static_cast<double>(1 << exponent) / kLastStep / 2;
    append_f32(manifest, (tileset.error_bound(exponent) + rounding) * nanometres);
  }
  for (int i = 0; i < 3 * levels; ++i) append_f32(manifest, 0);
  for (const auto& level : cells) append_u32(manifest, static_cast<std::uint32_t>(level.size()));
  for (auto& level : cells) {
    std::sort(level.begin(), level.end(), comes_before);
    for (const auto axis : {&OctreeCube::x, &OctreeCube::y, &OctreeCube::z}) {
      for (const OctreeCube& cell : level) {
        append_u32(manifest, static_cast<std::uint32_t>(cell.*axis));
      }
    }
    for (const OctreeCube& cell : level) {
      const std::string& bytes = *fragments.at(cell);
      append_u32(manifest, static_cast<std::uint32_t>(bytes.size()));
      files.data += bytes;
    }
  }
  return files;
}

// Offsets count from the end of the shard's index; a manifest's offset from the end of the previous
// manifest. Fragments directly precede their manifest.
std::string mesh_shard(const std::map<std::uint64_t, MeshFiles>& segments) {
  std::string content;
  std::string keys;
  std::string offsets;
  std::string sizes;
  std::uint64_t last = 0;
  for (const auto& [segment, files] : segments) {
    append_u64(keys, segment - std::exchange(last, segment));
    append_u64(offsets, files.data.size());
    append_u64(sizes, files.manifest.size());
    content += files.data;
    content += files.manifest;
  }
  std::string shard;
  append_u64(shard, content.size());
  append_u64(shard, content.size() + keys.size() + offsets.size() + sizes.size());
  return shard + content + keys + offsets + sizes;
}

}  // namespace multitetra

#include "server/tilesets/tileset_json.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/json.hpp"
#include "server/core/framework/box.hpp"
#include "server/core/framework/level_extent.hpp"
#include "server/tilesets/detail/metres.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::ordered_json;

double length_of(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

// The bounds of all possible surfaces, in grid coordinates.
Box surface_box(const DatasetInfo& info) {
  if (info.outside) return box_of(OctreeCube{info.grid_exponent, 0, 0, 0});
  const auto place = [](GridPoint p) {
    return Vec3{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
  };
  return {place(first_sample(info)), place(last_sample(info))};
}

// The axis-aligned bounds of a tile's surface, in metres.
struct TileBox {
  Vec3 center;
  Vec3 half;
};

TileBox tile_box(const OctreeCube& cell, const DatasetInfo& info) {
  // Boxes of flat data get a minimum thickness, as viewers divide by it.
  constexpr double kMinHalfSide = 1.0 / 64;
  const Box box = clamped(box_of(cell), surface_box(info));
  const Vec3 step = grid_step_metres(info);
  TileBox tile{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    tile.center[axis] = step[axis] * (box.low[axis] + box.high[axis]) / 2;
    tile.half[axis] = step[axis] * std::max((box.high[axis] - box.low[axis]) / 2, kMinHalfSide);
  }
  return tile;
}

Json box_json(const TileBox& box) {
  Json numbers = Json::array();
  for (const double number : box.center) numbers.push_back(number);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) numbers.push_back(row == axis ? box.half[row] : 0);
  }
  return {{"box", std::move(numbers)}};
}

Json transform_json(const DatasetInfo& info) {
  const Affine map = grid_to_world(info);
  Json numbers = Json::array();
  for (const Vec3& column : map.columns) {
    for (const double number : column) numbers.push_back(number / length_of(column));
    numbers.push_back(0);
  }
  for (const double number : map.translation) numbers.push_back(metres_a_unit(info) * number);
  numbers.push_back(1);
  return numbers;
}

}  // namespace

Vec3 grid_step_metres(const DatasetInfo& info) {
  const Affine map = grid_to_world(info);
  Vec3 step{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    step[axis] = metres_a_unit(info) * length_of(map.columns[axis]);
  }
  return step;
}

std::string tileset_json(const Tileset& tileset, const OctreeCube& cell, const CellFacts& facts,
                         std::string_view folder) {
  const DatasetInfo& info = tileset.info();
  const auto box = [&](const OctreeCube& of) { return box_json(tile_box(of, info)); };
  const auto error = [&](const OctreeCube& of) {
    return metres_a_unit(info) * tileset.error_bound(of.exponent);
  };
  const auto uri = [&](const OctreeCube& of, const char* suffix) {
    return std::string(folder) + cell_name(of) + suffix;
  };
  // Before the tileset is shown, the error is the size of the data. The same applies if the
  // coarsest preview is empty.
  const double nothing_shown =
      std::max(2 * length_of(tile_box(tileset.root(), info).half), error(tileset.root()));
  const bool is_root = cell == tileset.root();
  Json tile;
  if (is_root) tile["transform"] = transform_json(info);
  tile["boundingVolume"] = box(cell);
  tile["geometricError"] = is_root && facts.is_empty ? nothing_shown : error(cell);
  tile["refine"] = "REPLACE";
  if (!facts.is_empty) tile["content"] = {{"uri", uri(cell, ".glb")}};
  Json children = Json::array();
  for (int i = 0; i < 8 && !tileset.is_leaf(cell); ++i) {
    if ((facts.crossed_octants >> i & 1U) == 0) continue;
    const OctreeCube child = cell.child(i);
    children.push_back({{"boundingVolume", box(child)},
                        {"geometricError", error(child)},
                        {"content", {{"uri", uri(child, ".json")}}}});
  }
  if (!children.empty()) tile["children"] = std::move(children);
  tile["extras"] = {{"cell", cell_name(cell)},
                    {"isCertified", !tileset.is_preview(cell.exponent)},
                    {"errorBound", tileset.error_bound(cell.exponent)}};
  const Json json = {{"asset", {{"version", "1.1"}, {"tilesetVersion", tileset.id()}}},
                     {"geometricError", is_root ? nothing_shown : error(cell)},
                     {"root", std::move(tile)}};
  return json_text(json) + "\n";
}

}  // namespace multitetra

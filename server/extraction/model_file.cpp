#include "server/extraction/model_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/core/errors/leaves.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little, "The file is written as little endian.");

struct Tetrahedra {
  std::vector<std::array<float, 3>> points;
  std::vector<float> values;
  std::vector<std::array<std::int64_t, 4>> cells;
  std::vector<std::int32_t> sizes;
};

std::int32_t size_of(const Tetrahedron& t) {
  std::int32_t size = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax({t.a[axis], t.b[axis], t.k[axis], t.d[axis]});
    size = std::max(size, high - low);
  }
  return size;
}

// Whether two corners have to change places for the order that VTK wants: the fourth corner on the
// side that the first three, turning counter-clockwise, face.
bool is_turned(const std::array<GridPoint, 4>& c, const Affine& map) {
  return (six_volumes(c[0], c[1], c[2], c[3]) < 0) != (map.determinant() < 0);
}

Tetrahedra collect(const Model& model, const Field& field, const Affine& map) {
  Tetrahedra result;
  std::unordered_map<std::uint64_t, std::int64_t> numbers;
  field.visit([&](const auto& sampled) {
    const auto number = [&](GridPoint p) {
      const auto [at, is_new] = numbers.try_emplace(
          LatticePoint{p.x, p.y, p.z}.key(), static_cast<std::int64_t>(result.points.size()));
      if (is_new) {
        const Vec3 x =
            map({static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
        result.points.push_back(
            {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
        result.values.push_back(sampled.at(p));
      }
      return at->second;
    };
    visit_leaves(model, field.grid(), root_cube(field.grid()), [&](const Tetrahedron& t) {
      auto corners = t.corners();
      if (std::any_of(corners.begin(), corners.end(),
                      [&](GridPoint p) { return is_void(sampled.at(p)); }))
        return;
      if (is_turned(corners, map)) std::swap(corners[2], corners[3]);
      result.cells.push_back(
          {number(corners[0]), number(corners[1]), number(corners[2]), number(corners[3])});
      result.sizes.push_back(size_of(t));
    });
  });
  return result;
}

// The part behind the XML: each array behind its length in bytes.
class Appended {
 public:
  template <typename Value>
  std::string add(const char* type, const char* name, std::size_t components,
                  const std::vector<Value>& values) {
    const std::string header = std::string("<DataArray type=\"") + type + "\" Name=\"" + name +
                               "\" NumberOfComponents=\"" + std::to_string(components) +
                               "\" format=\"appended\" offset=\"" + std::to_string(bytes_.size()) +
                               "\"/>\n";
    const std::uint64_t size = values.size() * sizeof(Value);
    bytes_.append(reinterpret_cast<const char*>(&size), sizeof(size));
    bytes_.append(reinterpret_cast<const char*>(values.data()), size);
    return header;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

std::string vtu_file(const Model& model, const Field& field, const Affine& grid_to_output) {
  const Tetrahedra tetrahedra = collect(model, field, grid_to_output);
  std::vector<std::int64_t> offsets;
  for (std::size_t i = 1; i <= tetrahedra.cells.size(); ++i)
    offsets.push_back(static_cast<std::int64_t>(4 * i));
  constexpr std::uint8_t kVtkTetra = 10;
  const std::vector<std::uint8_t> types(tetrahedra.cells.size(), kVtkTetra);

  Appended appended;
  std::string file =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
      std::to_string(tetrahedra.points.size()) + "\" NumberOfCells=\"" +
      std::to_string(tetrahedra.cells.size()) + "\">\n";
  file += "<PointData Scalars=\"value\">\n" +
          appended.add("Float32", "value", 1, tetrahedra.values) + "</PointData>\n";
  file += "<CellData>\n" + appended.add("Int32", "size", 1, tetrahedra.sizes) + "</CellData>\n";
  file += "<Points>\n" + appended.add("Float32", "points", 3, tetrahedra.points) + "</Points>\n";
  file += "<Cells>\n" + appended.add("Int64", "connectivity", 1, tetrahedra.cells) +
          appended.add("Int64", "offsets", 1, offsets) + appended.add("UInt8", "types", 1, types) +
          "</Cells>\n";
  file += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  file += appended.bytes();
  file += "\n</AppendedData>\n</VTKFile>\n";
  return file;
}

}  // namespace multitetra

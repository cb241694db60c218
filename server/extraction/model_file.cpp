#include "server/extraction/model_file.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little, "The file is written as little endian.");

using Position = std::array<float, 3>;

std::vector<Position> mapped(const std::vector<GridPoint>& points, const Affine& map) {
  std::vector<Position> positions;
  positions.reserve(points.size());
  for (const GridPoint p : points) {
    const Vec3 x =
        map({static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
    positions.push_back(
        {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
  }
  return positions;
}

// Restores the orientation of the cells after a mirroring map, as VTK requires.
std::vector<std::array<std::int64_t, 4>> turned(std::vector<std::array<std::int64_t, 4>> cells,
                                                bool is_mirrored) {
  if (is_mirrored) {
    for (auto& cell : cells) std::swap(cell[2], cell[3]);
  }
  return cells;
}

// The data after the XML: each array is preceded by its length in bytes.
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

std::string vtu_file(const ModelCells& model, const Affine& grid_to_output) {
  std::vector<std::int64_t> offsets;
  for (std::size_t i = 1; i <= model.cells.size(); ++i)
    offsets.push_back(static_cast<std::int64_t>(4 * i));
  constexpr std::uint8_t kVtkTetra = 10;
  const std::vector<std::uint8_t> types(model.cells.size(), kVtkTetra);

  Appended appended;
  std::string file =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
      std::to_string(model.points.size()) + "\" NumberOfCells=\"" +
      std::to_string(model.cells.size()) + "\">\n";
  file += "<PointData Scalars=\"value\">\n" + appended.add("Float32", "value", 1, model.values) +
          "</PointData>\n";
  file += "<CellData>\n" + appended.add("Int32", "size", 1, model.sizes) + "</CellData>\n";
  file += "<Points>\n" +
          appended.add("Float32", "points", 3, mapped(model.points, grid_to_output)) +
          "</Points>\n";
  file += "<Cells>\n" +
          appended.add("Int64", "connectivity", 1,
                       turned(model.cells, grid_to_output.determinant() < 0)) +
          appended.add("Int64", "offsets", 1, offsets) + appended.add("UInt8", "types", 1, types) +
          "</Cells>\n";
  file += "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  file += appended.bytes();
  file += "\n</AppendedData>\n</VTKFile>\n";
  return file;
}

}  // namespace multitetra

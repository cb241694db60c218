#include "common/wire/detail/vtp_file.hpp"

#include <bit>
#include <cstdint>
#include <vector>

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "VTP files are written as the bytes lie in memory: little-endian.");

// Collects the descriptions of the arrays, and their appended bytes, each preceded by its length.
class VtpArrays {
 public:
  template <typename T>
  std::string add(const char* name, const char* type, int components,
                  const std::vector<T>& values) {
    const std::string offset = std::to_string(bytes_.size());
    const std::uint64_t size = values.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes_.append(reinterpret_cast<const char*>(values.data()), size);
    return std::string("<DataArray type=\"") + type + "\" Name=\"" + name +
           "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"appended\" offset=\"" + offset + "\"/>\n";
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

std::string vtp_file(const PositionedMesh& mesh) {
  std::vector<std::int64_t> ends;
  for (std::size_t i = 1; i <= mesh.triangles.size(); ++i) {
    ends.push_back(static_cast<std::int64_t>(3 * i));
  }
  std::vector<std::array<std::int64_t, 3>> corners;
  for (const TriangleIndices& t : mesh.triangles) corners.push_back({t[0], t[1], t[2]});
  VtpArrays arrays;
  std::string file =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      std::to_string(mesh.positions.size()) + "\" NumberOfPolys=\"" +
      std::to_string(mesh.triangles.size()) + "\">\n<PointData" +
      (mesh.scalars.empty() ? "" : " Scalars=\"scalars\"") +
      (mesh.normals.empty() ? "" : " Normals=\"normals\"") + ">\n";
  if (!mesh.scalars.empty()) file += arrays.add("scalars", "Float32", 1, mesh.scalars);
  if (!mesh.normals.empty()) file += arrays.add("normals", "Float32", 3, mesh.normals);
  if (!mesh.colors.empty()) file += arrays.add("colors", "UInt8", 3, mesh.colors);
  file += "</PointData>\n<Points>\n" + arrays.add("points", "Float32", 3, mesh.positions) +
          "</Points>\n<Polys>\n" + arrays.add("connectivity", "Int64", 1, corners) +
          arrays.add("offsets", "Int64", 1, ends) +
          "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + arrays.bytes() +
          "\n</AppendedData>\n</VTKFile>\n";
  return file;
}

}  // namespace multitetra

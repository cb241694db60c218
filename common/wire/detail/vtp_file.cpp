#include "common/wire/detail/vtp_file.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "common/base/parse_number.hpp"
#include "common/wire/detail/file_positions.hpp"

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

// Returns the number in quotes after the first `before` that follows `from`.
std::size_t number_after(std::string_view text, std::string_view before, std::size_t from = 0) {
  const std::size_t at = text.find(before, from);
  const auto rest = at == text.npos ? std::string_view() : text.substr(at + before.size());
  const auto number = parse_number<std::uint64_t>(rest.substr(0, rest.find('"')));
  if (!number) throw std::runtime_error("it is not a VTP file of ours");
  return static_cast<std::size_t>(*number);
}

// Returns the elements of the appended array with this name.
template <typename T>
std::vector<T> appended(std::string_view file, std::string_view name, std::size_t count) {
  constexpr std::string_view kData = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t described = file.find("Name=\"" + std::string(name) + '"');
  const std::size_t offset = number_after(file, " offset=\"", described);
  const std::size_t begin = file.find(kData) + kData.size() + offset + sizeof(std::uint64_t);
  std::vector<T> values(count);
  if (begin > file.size() || count * sizeof(T) > file.size() - begin) {
    throw std::runtime_error("an array ends too early");
  }
  if (count > 0) std::memcpy(values.data(), file.data() + begin, count * sizeof(T));
  return values;
}

}  // namespace

TriangleMesh read_own_vtp(std::string_view file) {
  const std::size_t vertices = number_after(file, "NumberOfPoints=\"");
  const std::size_t triangles = number_after(file, "NumberOfPolys=\"");
  TriangleMesh mesh;
  if (file.find("type=\"Float64\" Name=\"points\"") != file.npos) {
    mesh.vertices = appended<Vec3>(file, "points", vertices);
  } else {
    for (const auto& place : appended<std::array<float, 3>>(file, "points", vertices)) {
      mesh.vertices.push_back(vec3(place));
    }
  }
  for (const auto& corners :
       appended<std::array<std::int64_t, 3>>(file, "connectivity", triangles)) {
    TriangleIndices& triangle = mesh.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      if (corners[i] < 0 || corners[i] >= static_cast<std::int64_t>(vertices)) {
        throw std::runtime_error("a triangle refers to a missing vertex");
      }
      triangle[i] = static_cast<std::uint32_t>(corners[i]);
    }
  }
  return mesh;
}

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
  file += "</PointData>\n<Points>\n" +
          (fits_in_floats(mesh) ? arrays.add("points", "Float32", 3, float_positions(mesh))
                                : arrays.add("points", "Float64", 3, mesh.positions)) +
          "</Points>\n<Polys>\n" + arrays.add("connectivity", "Int64", 1, corners) +
          arrays.add("offsets", "Int64", 1, ends) +
          "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_" + arrays.bytes() +
          "\n</AppendedData>\n</VTKFile>\n";
  return file;
}

}  // namespace multitetra

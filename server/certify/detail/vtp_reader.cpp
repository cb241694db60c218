#include "server/certify/detail/vtp_reader.hpp"

#include <algorithm>
#include <string>

#include "common/wire/polygon_sink.hpp"
#include "server/volume/formats/vtk/vtk_arrays.hpp"

namespace multitetra {
namespace {

// Reads the numbers of an array of any type in order.
class VtkNumbers {
 public:
  VtkNumbers(const VtkArrays& arrays, const VtiArray& array, std::uint64_t count)
      : type_(array.type), left_(count) {
    if (count > 0) bytes_ = arrays.open(array, count);
  }

  double take() {
    if (at_ == buffer_.size()) fill();
    const std::byte* const from = buffer_.data() + at_;
    at_ += bytes_of(type_);
    return number_from(type_, from);
  }
  // Reads an index, an integer below 2^53.
  std::int64_t take_index() {
    const double value = take();
    if (!(value >= 0 && value < 0x1p53)) throw MeshFileError("a vertex index is invalid");
    return static_cast<std::int64_t>(value);
  }

 private:
  void fill() {
    constexpr std::uint64_t kPortion = 1 << 16;
    const std::uint64_t count = std::min(left_, kPortion);
    if (count == 0) throw MeshFileError("an array ends too early");
    buffer_.resize(count * bytes_of(type_));
    bytes_->read(read_, buffer_);
    read_ += buffer_.size();
    left_ -= count;
    at_ = 0;
  }

  StoredType type_;
  std::uint64_t left_;
  std::unique_ptr<SampleBytes> bytes_;
  std::vector<std::byte> buffer_;
  std::size_t at_ = 0;
  std::uint64_t read_ = 0;
};

const VtiArray& array_of(const VtiHeader& header, std::string_view section, std::string_view name) {
  for (const VtiArray& array : header.arrays) {
    if (array.section == section && (name.empty() || array.name == name)) return array;
  }
  throw MeshFileError("its " + std::string(section) + " have no array '" + std::string(name) + "'");
}

// Calls `begin()` for each cell of a section, `add(vertex)` for each of its vertices and `end()`.
template <typename Begin, typename Add, typename End>
void visit_cells(const VtkArrays& arrays, std::string_view section, std::uint64_t cells,
                 const Begin& begin, const Add& add, const End& end_cell) {
  if (cells == 0) return;
  const VtiArray& offsets = array_of(arrays.header(), section, "offsets");
  std::vector<std::int64_t> ends;
  VtkNumbers of_ends(arrays, offsets, cells);
  for (std::uint64_t i = 0; i < cells; ++i) {
    ends.push_back(of_ends.take_index());
    if (i > 0 && ends[i] < ends[i - 1])
      throw MeshFileError("the offsets of its cells do not increase");
  }
  VtkNumbers vertices(arrays, array_of(arrays.header(), section, "connectivity"),
                      static_cast<std::uint64_t>(ends.back()));
  std::int64_t at = 0;
  for (const std::int64_t end : ends) {
    begin();
    for (; at < end; ++at) add(vertices.take_index());
    end_cell();
  }
}

}  // namespace

TriangleMesh read_vtp(const std::filesystem::path& file) {
  const VtkArrays arrays(file, VtkDataKind::kPolyData);
  const VtiHeader& header = arrays.header();
  TriangleMesh mesh;
  if (header.points > 0) {
    const VtiArray& points = array_of(header, "Points", "");
    if (points.components != 3) throw MeshFileError("its points do not have three coordinates");
    VtkNumbers coordinates(arrays, points, 3 * header.points);
    for (std::uint64_t i = 0; i < header.points; ++i) {
      Vec3& place = mesh.vertices.emplace_back();
      for (double& coordinate : place) coordinate = coordinates.take();
    }
  }
  PolygonSink sink(mesh);
  const auto add = [&](std::int64_t vertex) { sink.add(vertex); };
  visit_cells(
      arrays, "Polys", header.polys, [&] { sink.begin(); }, add, [&] { sink.end(); });
  std::vector<std::int64_t> strip;
  visit_cells(
      arrays, "Strips", header.strips, [&] { strip.clear(); },
      [&](std::int64_t vertex) {
        strip.push_back(vertex);
        const std::size_t n = strip.size();
        if (n < 3) return;
        // Every second triangle of a strip has the opposite orientation.
        const bool is_even = n % 2 == 1;
        sink.begin();
        for (const std::size_t i : {is_even ? n - 3 : n - 2, is_even ? n - 2 : n - 3, n - 1}) {
          sink.add(strip[i]);
        }
        sink.end();
      },
      [] {});
  return mesh;
}

}  // namespace multitetra

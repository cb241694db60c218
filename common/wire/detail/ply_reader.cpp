// PLY: a text header that lists elements and their properties, then their values as text or binary.
#include <optional>
#include <vector>

#include "common/image/stored_type.hpp"
#include "common/wire/detail/mesh_bytes.hpp"

namespace multitetra {
namespace {

enum class PlyEncoding { kText, kLittle, kBig };

struct PlyProperty {
  std::string name;
  StoredType type = StoredType::kF32;
  // For a list, the type of its length.
  std::optional<StoredType> count = std::nullopt;
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties = {};
};

StoredType ply_type(std::string_view word) {
  if (const auto type = stored_type_from_word(word)) return *type;
  throw MeshFileError("its header has the unknown type '" + std::string(word.substr(0, 40)) + "'");
}

// Reads the values of elements in any encoding.
class PlyValues {
 public:
  PlyValues(MeshBytes bytes, PlyEncoding encoding) : bytes_(bytes), encoding_(encoding) {}

  [[nodiscard]] std::size_t bytes_left() const { return bytes_.size(); }

  double take(StoredType type) {
    if (encoding_ == PlyEncoding::kText) return bytes_.take_decimal();
    const bool is_big = encoding_ == PlyEncoding::kBig;
    return with_number_type(type, [&]<typename Number>() {
      return static_cast<double>(bytes_.take_number<Number>(is_big));
    });
  }

  // Reads an integer of at most 32 bits.
  std::int64_t take_integer(StoredType type) {
    const double value = take(type);
    const bool fits = value >= -2147483648.0 && value <= 4294967295.0;
    if (!fits || value != static_cast<double>(static_cast<std::int64_t>(value))) {
      throw MeshFileError("a list has a number that is not an integer");
    }
    return static_cast<std::int64_t>(value);
  }

 private:
  MeshBytes bytes_;
  PlyEncoding encoding_;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;
};

PlyHeader take_header(MeshBytes& bytes) {
  PlyHeader header;
  bytes.take_line();  // "ply"
  while (!bytes.is_empty()) {
    MeshBytes line(bytes.take_line());
    const std::string_view word = line.take_word();
    if (word == "end_header") return header;
    if (word == "format") {
      const std::string_view name = line.take_word();
      if (name == "ascii") {
        header.encoding = PlyEncoding::kText;
      } else if (name == "binary_little_endian") {
        header.encoding = PlyEncoding::kLittle;
      } else if (name == "binary_big_endian") {
        header.encoding = PlyEncoding::kBig;
      } else {
        throw MeshFileError("its format is unknown: '" + std::string(name.substr(0, 40)) + "'");
      }
    } else if (word == "element") {
      PlyElement element{.name = std::string(line.take_word())};
      element.count = integer_from(line.take_word());
      // Each element takes at least a byte.
      if (element.count < 0 || element.count > static_cast<std::int64_t>(bytes.size())) {
        throw MeshFileError("it is shorter than the " + std::to_string(element.count) +
                                " elements '" + element.name.substr(0, 40) +
                                "' that its header declares",
                            kGetCompleteCopy);
      }
      header.elements.push_back(std::move(element));
    } else if (word == "property") {
      if (header.elements.empty())
        throw MeshFileError("its header has a property without an element");
      PlyProperty property;
      std::string_view type = line.take_word();
      if (type == "list") {
        property.count = ply_type(line.take_word());
        type = line.take_word();
      }
      property.type = ply_type(type);
      property.name = line.take_word();
      header.elements.back().properties.push_back(std::move(property));
    }
  }
  throw MeshFileError("its header has no end_header line");
}

void take_vertices(const PlyElement& element, PlyValues& values, TriangleMesh& mesh) {
  unsigned axes = 0;
  for (const PlyProperty& property : element.properties) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (!property.count && property.name == std::string(1, "xyz"[axis])) axes |= 1U << axis;
    }
  }
  if (axes != 7) throw MeshFileError("its vertices do not have x, y and z");
  for (std::int64_t i = 0; i < element.count; ++i) {
    Vec3& place = mesh.vertices.emplace_back();
    for (const PlyProperty& property : element.properties) {
      if (property.count) {
        for (std::int64_t n = values.take_integer(*property.count); n > 0; --n) {
          (void)values.take(property.type);
        }
        continue;
      }
      const double value = values.take(property.type);
      const std::size_t axis = std::string_view("xyz").find(property.name);
      if (property.name.size() == 1 && axis != std::string_view::npos) place[axis] = value;
    }
  }
}

// Reads the lists of faces and skips those of other elements.
void take_lists(const PlyElement& element, PlyValues& values, TriangleMesh& mesh) {
  PolygonSink sink(mesh);
  for (std::int64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!property.count) {
        (void)values.take(property.type);
        continue;
      }
      const bool is_face = element.name == "face" &&
                           (property.name == "vertex_indices" || property.name == "vertex_index");
      sink.begin();
      for (std::int64_t n = values.take_integer(*property.count); n > 0; --n) {
        if (is_face) {
          sink.add(values.take_integer(property.type));
        } else {
          (void)values.take(property.type);
        }
      }
      sink.end();
    }
  }
}

}  // namespace

TriangleMesh read_ply(std::string_view file) {
  MeshBytes bytes(file);
  const PlyHeader header = take_header(bytes);
  PlyValues values(bytes, header.encoding);
  TriangleMesh mesh;
  bool has_vertices = false;
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) continue;
    if (element.name == "tristrips") {
      throw MeshFileError("its triangles are strips, which are not supported");
    }
    if (element.name == "vertex") {
      has_vertices = true;
      take_vertices(element, values, mesh);
    } else {
      take_lists(element, values, mesh);
    }
  }
  if (!has_vertices) throw MeshFileError("it has no vertices");
  return mesh;
}

}  // namespace multitetra

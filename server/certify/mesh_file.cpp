#include "server/certify/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <optional>

#include "common/base/number_text.hpp"
#include "common/base/open_file.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/base/utf8.hpp"
#include "common/dataset/length_units.hpp"
#include "common/mesh/lattice.hpp"
#include "common/sandbox/packed.hpp"
#include "common/sandbox/sandbox.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/mesh_readers.hpp"
#include "server/certify/detail/vtp_reader.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string contents_of(const fs::path& file) {
  const OpenFile opened(file);
  if (!opened.regular_size()) fail_reading(file, "the file does not exist", "Check its name");
  auto bytes = opened.content(SIZE_MAX);
  if (!bytes) fail_reading(file, "it cannot be read", "Check the disk");
  return *std::move(bytes);
}

// Returns the text after the title of our files in the same line: ", lattice 5, min_component 12".
std::string_view facts_in(std::string_view file) {
  constexpr std::size_t kWithin = 256;
  const std::string_view header = file.substr(0, kWithin);
  const std::size_t title = header.find(kMeshFileTitle);
  if (title == std::string_view::npos) return {};
  const std::string_view facts = header.substr(title + kMeshFileTitle.size());
  return facts.substr(0, facts.find('\n'));
}

template <typename Number>
std::optional<Number> fact(std::string_view facts, std::string_view name) {
  const std::string before = ", " + std::string(name) + " ";
  const std::size_t found = facts.find(before);
  if (found == std::string_view::npos) return std::nullopt;
  const std::string_view rest = facts.substr(found + before.size());
  return parse_number<Number>(rest.substr(0, rest.find_first_not_of("0123456789.e+-")));
}

TriangleMesh with_facts(TriangleMesh mesh, std::string_view file) {
  const std::string_view facts = facts_in(file);
  const auto lattice = fact<int>(facts, "lattice");
  if (lattice && *lattice >= kMinLatticeResolution && *lattice <= kMaxLatticeResolution) {
    mesh.lattice = lattice;
  }
  const auto diagonal = fact<double>(facts, "min_component");
  if (diagonal && *diagonal > 0 && std::isfinite(*diagonal)) mesh.min_component = *diagonal;
  return mesh;
}

// Returns the format that the content shows, or nullopt.
std::optional<MeshFormat> format_by_content(std::string_view bytes) {
  constexpr std::size_t kWithin = 4096;
  if (bytes.starts_with("glTF")) return MeshFormat::kGlb;
  if (bytes.starts_with("PK\3\4")) return MeshFormat::k3mf;
  if (bytes.starts_with("DRACO")) return MeshFormat::kDrc;
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return MeshFormat::kPly;
  constexpr std::size_t kStlHeader = 84;
  if (bytes.size() >= kStlHeader) {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, bytes.data() + kStlHeader - 4, sizeof triangles);
    if (bytes.size() == kStlHeader + std::size_t{50} * triangles) return MeshFormat::kStl;
  }
  std::string_view text = bytes.substr(0, kWithin);
  if (text.find("<VTKFile") != text.npos) return MeshFormat::kVtp;
  while (!text.empty()) {
    std::string_view line = take_line(text);
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == line.npos || line[begin] == '#') continue;
    line.remove_prefix(begin);
    const std::string word = lower_case(line.substr(0, line.find_first_of(" \t\r")));
    if (word == "solid") return MeshFormat::kStl;
    constexpr std::array<std::string_view, 10> kObjWords = {"v", "vn",     "vt",     "f", "o",
                                                            "g", "mtllib", "usemtl", "s", "l"};
    const bool is_obj = std::find(kObjWords.begin(), kObjWords.end(), word) != kObjWords.end();
    return is_obj ? std::optional(MeshFormat::kObj) : std::nullopt;
  }
  return std::nullopt;
}

TriangleMesh read(const fs::path& file) {
  const std::optional<MeshFormat> by_suffix = mesh_format_from(file.extension().string());
  if (by_suffix == MeshFormat::kVtp) return read_vtp(file);
  std::string bytes = contents_of(file);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // Of text, by some editors.
  if (bytes.starts_with(kByteOrderMark) && format_by_content(bytes) != MeshFormat::kStl) {
    bytes.erase(0, kByteOrderMark.size());
  }
  const std::optional<MeshFormat> by_content = format_by_content(bytes);
  const bool has_no_signature = by_suffix == MeshFormat::kStl || by_suffix == MeshFormat::kObj;
  const std::optional<MeshFormat> format = by_content || !has_no_signature ? by_content : by_suffix;
  if (!format) {
    throw MeshFileError(
        "its format is unknown: it begins with neither 'ply', 'glTF', 'DRACO', 'solid' nor as a "
        "zip (3MF), has no "
        "'<VTKFile', no lines of OBJ and not the length of binary STL, and its name ends in "
        "neither .stl nor .obj");
  }
  switch (*format) {
    case MeshFormat::kPly:
      return with_facts(read_ply(bytes), bytes);
    case MeshFormat::kStl:
      return with_facts(read_stl(bytes), bytes);
    case MeshFormat::kObj:
      return with_facts(read_obj(bytes), bytes);
    case MeshFormat::kGlb:
      return read_glb(bytes);
    case MeshFormat::kDrc:
      return read_draco(bytes);
    case MeshFormat::k3mf: {
      const std::string model = three_mf_model(bytes);
      return with_facts(read_three_mf_model(model), model);
    }
    case MeshFormat::kVtp:
      return read_vtp(file);
  }
  return {};
}

// Checks the vertices, and finds whether all are floats.
void check_vertices(TriangleMesh& mesh) {
  mesh.has_floats = true;
  for (const Vec3& vertex : mesh.vertices) {
    // Larger coordinates make squared lengths overflow or meaningless.
    constexpr double kMaxVertexCoordinate = 1e100;
    for (const double coordinate : vertex) {
      if (!(std::abs(coordinate) < kMaxVertexCoordinate))
        throw MeshFileError("a coordinate is not a number");
      mesh.has_floats = mesh.has_floats && double{static_cast<float>(coordinate)} == coordinate;
    }
  }
}

// ---- in a sandbox

// Kinds of messages: vertices, triangles, what the file says of them, the reason of a failure.
constexpr char kVertices = 'v';
constexpr char kTriangles = 't';
constexpr char kFacts = 'e';
constexpr char kFailed = 'f';
constexpr std::size_t kMessageBytes = std::size_t{12} << 20;  // Whole vertices and triangles.

constexpr std::uint64_t kReaderMemory = std::uint64_t{12} << 30;
constexpr std::chrono::minutes kReaderTime{10};

template <typename T>
void send_all(SandboxChannel& parent, char kind, const std::vector<T>& values) {
  std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  for (; !bytes.empty(); bytes.remove_prefix(std::min(kMessageBytes, bytes.size()))) {
    parent.send(kind, bytes.substr(0, kMessageBytes));
  }
}

const SandboxTask kReadMesh = {
    "read mesh", [](SandboxChannel& parent, const std::string& file) {
      try {
        const TriangleMesh mesh = read_mesh_here(file);
        send_all(parent, kVertices, mesh.vertices);
        send_all(parent, kTriangles, mesh.triangles);
        parent.send(kFacts, packed_values(mesh.lattice, mesh.min_component, mesh.length_unit));
      } catch (const std::bad_alloc&) {
        parent.send(kFailed, {});
      } catch (const std::exception& problem) {
        parent.send(kFailed, problem.what());
      }
    }};

// Appends the values of a message. Returns false if it has parts of one, or there are too many.
template <typename T>
bool append(std::string_view bytes, std::vector<T>& values) {
  const std::size_t count = bytes.size() / sizeof(T);
  if (bytes.size() % sizeof(T) != 0 || count > kMaxMeshElements - values.size()) return false;
  values.resize(values.size() + count);
  std::memcpy(static_cast<void*>(values.data() + (values.size() - count)), bytes.data(),
              bytes.size());
  return true;
}

bool is_valid(const TriangleMesh& mesh) {
  const auto is_corner = [&](std::uint32_t corner) { return corner < mesh.vertices.size(); };
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const TriangleIndices& t) {
                       return std::all_of(t.begin(), t.end(), is_corner);
                     }) &&
         (!mesh.lattice ||
          (*mesh.lattice >= kMinLatticeResolution && *mesh.lattice <= kMaxLatticeResolution)) &&
         mesh.min_component >= 0 && std::isfinite(mesh.min_component) &&
         (mesh.length_unit.empty() || metres_of(mesh.length_unit));
}

// Returns the mesh that the reader sends. Throws MeshFileError.
TriangleMesh received(Sandbox& reader) {
  TriangleMesh mesh;
  SandboxMessage message;
  bool is_whole = true;
  while (is_whole && message.kind != kFacts) {
    if (!reader.channel().receive(message, kReaderTime)) reader.throw_exit_reason();
    if (message.kind == kFailed && message.bytes.empty()) {
      throw MeshFileError("there is not enough memory for it",
                          "Use a machine with more memory, or a coarser mesh");
    }
    if (message.kind == kFailed) throw VolumeFileError(printable(message.bytes));
    is_whole = message.kind == kVertices ? append(message.bytes, mesh.vertices)
               : message.kind == kTriangles
                   ? append(message.bytes, mesh.triangles)
                   : message.kind == kFacts && unpack_all(message.bytes, mesh.lattice,
                                                          mesh.min_component, mesh.length_unit);
  }
  if (!is_whole || !is_valid(mesh)) {
    throw MeshFileError("its reader does not answer as a reader does");
  }
  check_vertices(mesh);
  return mesh;
}

}  // namespace

TriangleMesh read_mesh_here(const fs::path& file) {
  try {
    TriangleMesh mesh = read(file);
    check_vertices(mesh);
    return mesh;
  } catch (const MeshFileError& fault) {
    fail_reading(file, fault.what(), fault.remedy());
  }
}

TriangleMesh read_mesh(const fs::path& file) {
  try {
    Sandbox reader(kReadMesh, {.readable = {file}, .memory_bytes = kReaderMemory}, file.string());
    return received(reader);
  } catch (const MeshFileError& fault) {
    fail_reading(file, fault.what(), fault.remedy());
  } catch (const SandboxError& fault) {
    fail_reading(file, fault.what(), "Save it as PLY with triangles alone");
  }
}

std::vector<std::string> convert_to_unit(TriangleMesh& mesh, const std::string& unit) {
  const std::optional<double> known = length_factor(mesh.length_unit, unit);
  if (!known || *known == 1) return {};
  const double factor = *known;
  for (Vec3& vertex : mesh.vertices) vertex = scaled(vertex, factor);
  const std::string notice = "The mesh file is in " + mesh.length_unit + ", the volume in " + unit +
                             ": its coordinates were multiplied by " + shortest_text(factor) + '.';
  mesh.length_unit = unit;
  return {notice};
}

}  // namespace multitetra

#include <expat.h>
#include <zip.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/affine.hpp"
#include "common/base/parse_number.hpp"
#include "common/wire/detail/instances.hpp"
#include "common/wire/detail/mesh_bytes.hpp"
#include "common/wire/mesh_readers.hpp"

namespace multitetra {
namespace {

using Attributes = std::map<std::string_view, std::string_view>;

// Builds the meshes of a model from its elements.
class ModelReader {
 public:
  explicit ModelReader(std::vector<std::size_t>* first) : first_(first) {}

  void start(std::string_view name, const Attributes& attributes) {
    name.remove_prefix(std::min(name.find(':') + 1, name.size()));
    const auto number = [&](std::string_view key) {
      const auto found = attributes.find(key);
      if (found == attributes.end()) fail("an element <" + std::string(name) + "> is incomplete");
      return found->second;
    };
    if (name == "object") {
      object_ = &objects_[std::string(number("id"))];
    } else if (name == "components") {
      fail("it is composed of parts (<components>), which are not read");
    } else if (name == "vertex" && object_ != nullptr) {
      object_->vertices.push_back(
          {decimal_from(number("x")), decimal_from(number("y")), decimal_from(number("z"))});
    } else if (name == "triangle" && object_ != nullptr) {
      object_->triangles.push_back(
          {index_from(number("v1")), index_from(number("v2")), index_from(number("v3"))});
    } else if (name == "item") {
      const bool is_elsewhere = std::any_of(attributes.begin(), attributes.end(),
                                            [](auto& one) { return one.first.ends_with(":path"); });
      if (is_elsewhere) fail("an item is in another model (p:path), which is not read");
      const auto transform = attributes.find("transform");
      build(std::string(number("objectid")),
            transform == attributes.end() ? std::string_view() : transform->second);
    }
    const bool is_large = object_ != nullptr && (object_->vertices.size() > kMaxMeshElements ||
                                                 object_->triangles.size() > kMaxMeshElements);
    if (is_large) fail("it has too many triangles");
  }

  [[nodiscard]] TriangleMesh read() const {
    InstanceCount instances;
    for (const auto& [object, map] : items_)
      instances.add(object->vertices.size(), object->triangles.size());
    TriangleMesh mesh;
    for (const auto& [object, map] : items_) {
      for (const TriangleIndices& corners : object->triangles) {
        for (const std::uint32_t corner : corners) {
          if (corner >= object->vertices.size())
            fail("a triangle refers to a vertex that does not exist");
        }
      }
      if (first_ != nullptr) first_->push_back(mesh.triangles.size());
      append(mesh, *object, map);
    }
    return mesh;
  }

 private:
  [[noreturn]] static void fail(const std::string& problem) { throw MeshFileError(problem); }

  static std::uint32_t index_from(std::string_view text) {
    const auto index = parse_number<std::uint32_t>(text);
    if (!index) fail("'" + std::string(text.substr(0, 40)) + "' is no index of a vertex");
    return *index;
  }

  // Three columns of numbers, then the translation.
  static Affine map_from(std::string_view text) {
    MeshBytes words(text);
    Affine map;
    if (text.empty()) return map;
    for (Vec3* const row : {&map.columns[0], &map.columns[1], &map.columns[2], &map.translation}) {
      for (double& entry : *row) entry = words.take_decimal();
    }
    return map;
  }

  void build(const std::string& id, std::string_view transform) {
    const auto found = objects_.find(id);
    if (found == objects_.end())
      fail("an item refers to object " + id + ", which is not in its model");
    constexpr std::size_t kMaxItems = 1'000'000;
    if (items_.size() >= kMaxItems) fail("it has more than a million items");
    items_.emplace_back(&found->second, map_from(transform));
  }

  std::vector<std::size_t>* first_;
  std::map<std::string, TriangleMesh> objects_;
  TriangleMesh* object_ = nullptr;  // The one whose elements follow.
  std::vector<std::pair<const TriangleMesh*, Affine>> items_;
};

// Exceptions must not pass through expat.
struct Parsing {
  XML_Parser parser;
  ModelReader reader;
  std::exception_ptr problem = nullptr;  // No exception may pass through expat.
};

void stop(Parsing& parsing, std::exception_ptr problem) {
  parsing.problem = std::move(problem);
  XML_StopParser(parsing.parser, XML_FALSE);
}

void XMLCALL on_start(void* self, const XML_Char* name, const XML_Char** pairs) {
  auto& parsing = *static_cast<Parsing*>(self);
  try {
    Attributes attributes;
    for (; *pairs != nullptr; pairs += 2) attributes.emplace(pairs[0], pairs[1]);
    parsing.reader.start(name, attributes);
  } catch (...) {
    stop(parsing, std::current_exception());
  }
}

void XMLCALL on_entity(void* self, const XML_Char*, int, const XML_Char*, int, const XML_Char*,
                       const XML_Char*, const XML_Char*, const XML_Char*) {
  stop(*static_cast<Parsing*>(self),
       std::make_exception_ptr(MeshFileError("its XML declares entities, which are not allowed")));
}

}  // namespace

std::string three_mf_model(std::string_view file) {
  zip_source_t* const buffer = zip_source_buffer_create(file.data(), file.size(), 0, nullptr);
  const std::unique_ptr<zip_t, decltype(&zip_discard)> archive(
      buffer == nullptr ? nullptr : zip_open_from_source(buffer, ZIP_RDONLY, nullptr),
      &zip_discard);
  if (!archive) {
    zip_source_free(buffer);
    throw MeshFileError("it is not a complete zip archive", kGetCompleteCopy);
  }
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  std::optional<std::string> found;
  for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(std::max<zip_int64_t>(count, 0)); ++i) {
    const char* const name = zip_get_name(archive.get(), i, ZIP_FL_ENC_RAW);
    if (name == nullptr || !std::string_view(name).starts_with("3D/") ||
        std::string_view(name).substr(3).find('/') != std::string_view::npos ||
        !std::string_view(name).ends_with(".model")) {
      continue;
    }
    if (found) throw MeshFileError("it has several models in the folder 3D, which are not read");
    zip_stat_t stat{};
    const bool is_known = zip_stat_index(archive.get(), i, 0, &stat) == 0 &&
                          (stat.valid & ZIP_STAT_SIZE) != 0 &&
                          (stat.valid & ZIP_STAT_COMP_SIZE) != 0;
    // Deflate compresses at most about a thousandfold.
    if (!is_known || stat.comp_size > file.size() || stat.size / 1100 > stat.comp_size) break;
    const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> opened(
        zip_fopen_index(archive.get(), i, 0), &zip_fclose);
    std::string model(stat.size, '\0');
    char none = 0;
    const bool is_whole = opened != nullptr &&
                          zip_fread(opened.get(), model.data(), model.size()) ==
                              static_cast<zip_int64_t>(stat.size) &&
                          zip_fread(opened.get(), &none, 1) == 0;
    if (is_whole) {
      found = std::move(model);
      continue;
    }
    throw MeshFileError("its model '" + std::string(name) + "' is damaged", kGetCompleteCopy);
  }
  if (found) return *std::move(found);
  throw MeshFileError("it is a zip archive without a model of 3MF (3D/3dmodel.model)");
}

TriangleMesh read_three_mf_model(std::string_view model,
                                 std::vector<std::size_t>* first_triangles) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  Parsing parsing{.parser = parser.get(), .reader = ModelReader(first_triangles)};
  XML_SetUserData(parser.get(), &parsing);
  XML_SetStartElementHandler(parser.get(), &on_start);
  XML_SetEntityDeclHandler(parser.get(), &on_entity);
  constexpr std::size_t kPiece = std::size_t{1} << 24;
  XML_Status status = XML_STATUS_OK;
  for (std::size_t at = 0; status == XML_STATUS_OK && at < model.size(); at += kPiece) {
    const std::string_view piece = model.substr(at, kPiece);
    status = XML_Parse(parser.get(), piece.data(), static_cast<int>(piece.size()),
                       at + piece.size() == model.size() ? XML_TRUE : XML_FALSE);
  }
  if (parsing.problem) std::rethrow_exception(parsing.problem);
  if (status != XML_STATUS_OK) {
    throw MeshFileError("the XML of its model is damaged in line " +
                        std::to_string(XML_GetCurrentLineNumber(parser.get())));
  }
  return parsing.reader.read();
}

}  // namespace multitetra

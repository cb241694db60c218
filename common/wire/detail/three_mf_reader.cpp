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
#include "common/base/percent_encoded.hpp"
#include "common/dataset/length_units.hpp"
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
    if (name == "model") {
      const auto unit = attributes.find("unit");
      if (unit != attributes.end() && metres_of(unit->second)) unit_ = unit_from(unit->second);
    } else if (name == "object") {
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
    mesh.length_unit = unit_;
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
  std::string unit_;
  std::map<std::string, TriangleMesh> objects_;
  TriangleMesh* object_ = nullptr;  // The one whose elements follow.
  std::vector<std::pair<const TriangleMesh*, Affine>> items_;
};

// Finds the model of a package among its relationships.
struct RelationsReader {
  std::string model;

  void start(std::string_view, const Attributes& attributes) {
    const auto type = attributes.find("Type");
    const auto target = attributes.find("Target");
    const bool is_model = type != attributes.end() && target != attributes.end() &&
                          type->second.ends_with("/3dmodel");
    if (!is_model || !model.empty()) return;
    const std::string_view name = target->second.substr(target->second.starts_with('/') ? 1 : 0);
    model = percent_decoded(name).value_or(std::string(name));
  }
};

template <typename Reader>
struct Parsing {
  XML_Parser parser;
  Reader reader;
  std::exception_ptr problem = nullptr;  // No exception may pass through expat.

  void stop(std::exception_ptr fault) {
    problem = std::move(fault);
    XML_StopParser(parser, XML_FALSE);
  }
};

template <typename Reader>
void XMLCALL on_start(void* self, const XML_Char* name, const XML_Char** pairs) {
  auto& parsing = *static_cast<Parsing<Reader>*>(self);
  try {
    Attributes attributes;
    for (; *pairs != nullptr; pairs += 2) attributes.emplace(pairs[0], pairs[1]);
    parsing.reader.start(name, attributes);
  } catch (...) {
    parsing.stop(std::current_exception());
  }
}

template <typename Reader>
void XMLCALL on_entity(void* self, const XML_Char*, int, const XML_Char*, int, const XML_Char*,
                       const XML_Char*, const XML_Char*, const XML_Char*) {
  static_cast<Parsing<Reader>*>(self)->stop(
      std::make_exception_ptr(MeshFileError("its XML declares entities, which are not allowed")));
}

// Calls `reader.start(name, attributes)` for each element, and returns the reader.
template <typename Reader>
Reader parsed(std::string_view xml, const std::string& where, Reader reader) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  Parsing<Reader> parsing{.parser = parser.get(), .reader = std::move(reader)};
  XML_SetUserData(parser.get(), &parsing);
  XML_SetStartElementHandler(parser.get(), &on_start<Reader>);
  XML_SetEntityDeclHandler(parser.get(), &on_entity<Reader>);
  constexpr std::size_t kPiece = std::size_t{1} << 24;
  XML_Status status = XML_STATUS_OK;
  for (std::size_t at = 0; status == XML_STATUS_OK && at < xml.size(); at += kPiece) {
    const std::string_view piece = xml.substr(at, kPiece);
    status = XML_Parse(parser.get(), piece.data(), static_cast<int>(piece.size()),
                       at + piece.size() == xml.size() ? XML_TRUE : XML_FALSE);
  }
  if (parsing.problem) std::rethrow_exception(parsing.problem);
  if (status != XML_STATUS_OK) {
    throw MeshFileError("the XML of " + where + " is damaged in line " +
                        std::to_string(XML_GetCurrentLineNumber(parser.get())));
  }
  return std::move(parsing.reader);
}

// Returns the content of a file in an archive of `archive_bytes`; none if there is no such file.
std::optional<std::string> member(zip_t* archive, const std::string& name,
                                  std::size_t archive_bytes) {
  // Names of parts do not depend on case (Open Packaging Conventions, 6.2.2.3).
  const zip_int64_t index = zip_name_locate(archive, name.c_str(), ZIP_FL_NOCASE);
  if (index < 0) return std::nullopt;
  const auto at = static_cast<zip_uint64_t>(index);
  zip_stat_t stat{};
  constexpr zip_uint64_t kSizes = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
  // Deflate compresses at most about a thousandfold.
  const bool is_possible = zip_stat_index(archive, at, 0, &stat) == 0 &&
                           (stat.valid & kSizes) == kSizes && stat.comp_size <= archive_bytes &&
                           stat.size / 1100 <= stat.comp_size;
  if (is_possible) {
    const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> opened(zip_fopen_index(archive, at, 0),
                                                                    &zip_fclose);
    std::string content(stat.size, '\0');
    char none = 0;
    const bool is_whole = opened != nullptr &&
                          zip_fread(opened.get(), content.data(), content.size()) ==
                              static_cast<zip_int64_t>(stat.size) &&
                          zip_fread(opened.get(), &none, 1) == 0;
    if (is_whole) return content;
  }
  throw MeshFileError("its file '" + name.substr(0, 60) + "' is damaged", kGetCompleteCopy);
}

constexpr const char* kUsualModel = "3D/3dmodel.model";

// Returns the place of the model according to the relationships of a package; empty if these have
// none.
std::string model_named_in(std::string_view relations) {
  return parsed(relations, "its relationships", RelationsReader()).model;
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
  const std::optional<std::string> relations = member(archive.get(), "_rels/.rels", file.size());
  const std::string named = relations ? model_named_in(*relations) : std::string();
  if (auto model = member(archive.get(), named.empty() ? kUsualModel : named, file.size())) {
    return *std::move(model);
  }
  throw MeshFileError("it is a zip archive without " +
                      (named.empty() ? std::string("a model of 3MF (3D/3dmodel.model)")
                                     : "the model '" + named.substr(0, 60) + "' that it names"));
}

TriangleMesh read_three_mf_model(std::string_view model,
                                 std::vector<std::size_t>* first_triangles) {
  return parsed(model, "its model", ModelReader(first_triangles)).read();
}

}  // namespace multitetra

#include "common/wire/detail/three_mf_file.hpp"

#include <zip.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "common/dataset/length_units.hpp"
#include "common/wire/detail/file_positions.hpp"
#include "common/wire/detail/scene_writer.hpp"

namespace multitetra {
namespace {

constexpr const char* kModelFile = "3D/3dmodel.model";
constexpr std::string_view kTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
)";
constexpr std::string_view kRelations =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
)";

constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kUnits = {
    {{"µm", "micron"},
     {"mm", "millimeter"},
     {"cm", "centimeter"},
     {"in", "inch"},
     {"ft", "foot"},
     {"m", "meter"}}};

// The unit of a model, and the factor from the world's unit: files without a unit are in mm.
struct ModelUnit {
  std::string_view name = {};  // Empty: unknown.
  double factor = 1;
};

ModelUnit unit_of(const PhysicalMeaning& world) {
  const auto same =
      std::ranges::find(kUnits, world.length_unit, [](auto& one) { return one.first; });
  if (same != kUnits.end()) return {.name = same->second};
  const std::optional<double> metres = metres_of(world.length_unit);
  if (!metres) return {};
  const std::string_view symbol = *metres < 1e-6 ? "µm" : *metres < 1 ? "mm" : "m";
  const auto found = std::ranges::find(kUnits, symbol, [](auto& one) { return one.first; });
  return {.name = found->second, .factor = *length_factor(world.length_unit, symbol)};
}

std::vector<Vec3> scaled_positions(const PositionedMesh& mesh, double factor) {
  std::vector<Vec3> positions = mesh.positions;
  for (Vec3& position : positions) position = scaled(position, factor);
  return positions;
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return result;
}

// "#RRGGBB" of linear light.
std::string srgb_text(const std::array<double, 3>& light) {
  std::string text = "#";
  for (const double part : light) {
    const double shown = part <= 0.0031308 ? 12.92 * part : 1.055 * std::pow(part, 1 / 2.4) - 0.055;
    std::array<char, 3> hex{};
    (void)std::snprintf(hex.data(), hex.size(), "%02X",
                        static_cast<unsigned>(std::lround(255 * std::clamp(shown, 0.0, 1.0))));
    text += hex.data();
  }
  return text;
}

std::string color_text(const ScenePart& part, std::size_t number) {
  if (!part.name.color) return srgb_text(part_color(number));
  std::array<char, 8> text{};
  (void)std::snprintf(text.data(), text.size(), "#%06X", *part.name.color & 0xFFFFFFU);
  return text.data();
}

// Appends `<name a="1" b="2" c="3"/>`.
template <typename Number>
void append_element(std::string& xml, std::string_view name,
                    const std::array<std::string_view, 3>& keys,
                    const std::array<Number, 3>& numbers) {
  xml += '<';
  xml += name;
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), numbers[i]).ptr;
    xml += ' ';
    xml += keys[i];
    xml += "=\"";
    xml.append(text.data(), static_cast<std::size_t>(end - text.data()));
    xml += '"';
  }
  xml += "/>\n";
}

template <typename Positions>
void append_mesh(std::string& xml, const Positions& positions,
                 const std::vector<TriangleIndices>& triangles) {
  xml.reserve(xml.size() + 60 * positions.size() + 50 * triangles.size());
  xml += "<mesh><vertices>\n";
  for (const auto& place : positions) append_element(xml, "vertex", {"x", "y", "z"}, place);
  xml += "</vertices><triangles>\n";
  for (const TriangleIndices& corners : triangles) {
    append_element(xml, "triangle", {"v1", "v2", "v3"}, corners);
  }
  xml += "</triangles></mesh>";
}

std::string model_of(std::span<const ScenePart> parts, const PhysicalMeaning& world,
                     const std::string& title) {
  const ModelUnit unit = unit_of(world);
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- " + title + "\n -->\n<model";
  if (!unit.name.empty()) xml += " unit=\"" + std::string(unit.name) + '"';
  xml += " xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n";
  if (unit.name.empty() && !world.length_unit.empty()) {
    xml += "<metadata name=\"Description\">length unit " + escaped(world.length_unit) +
           "</metadata>\n";
  }
  std::string objects;
  std::string items;
  xml += "<resources><basematerials id=\"1\">";
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const PositionedMesh& mesh = *parts[i].mesh;
    const std::string name = escaped(parts[i].name.text);
    xml += "<base name=\"" + name + "\" displaycolor=\"" + color_text(parts[i], i) + "\"/>";
    if (mesh.triangles.empty()) continue;
    const std::string number = std::to_string(i + 2);
    objects += "<object id=\"" + number + "\" type=\"" + (is_closed(mesh) ? "model" : "surface") +
               "\" name=\"" + name + "\" pid=\"1\" pindex=\"" + std::to_string(i) + "\">";
    if (unit.factor != 1) {
      append_mesh(objects, scaled_positions(mesh, unit.factor), mesh.triangles);
    } else if (fits_in_floats(mesh)) {
      append_mesh(objects, float_positions(mesh), mesh.triangles);
    } else {
      append_mesh(objects, mesh.positions, mesh.triangles);
    }
    objects += "</object>\n";
    items += "<item objectid=\"" + number + "\"/>";
  }
  return xml + "</basematerials>\n" + objects + "</resources>\n<build>" + items +
         "</build>\n</model>\n";
}

[[noreturn]] void fail_to_write() {
  throw std::system_error(std::make_error_code(std::errc::file_too_large),
                          "a 3MF file cannot be packed");
}

// Adds a file whose bytes must outlive the archive.
void add_file(zip_t* archive, const char* name, std::string_view bytes) {
  zip_source_t* const source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
  const zip_int64_t index = source == nullptr ? -1 : zip_file_add(archive, name, source, 0);
  if (index < 0) fail_to_write();
  // Equal meshes have equal bytes: the time is that of the format's beginning.
  (void)zip_file_set_mtime(archive, static_cast<zip_uint64_t>(index), 315'532'800, 0);
}

}  // namespace

std::string three_mf_file(std::span<const ScenePart> parts, const PhysicalMeaning& world,
                          const std::string& title) {
  const std::string model = model_of(parts, world, title);
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const buffer = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_t* const archive =
      buffer == nullptr ? nullptr : zip_open_from_source(buffer, ZIP_TRUNCATE, &error);
  zip_error_fini(&error);
  if (archive == nullptr) fail_to_write();
  zip_source_keep(buffer);
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> owned(buffer, &zip_source_free);
  add_file(archive, "[Content_Types].xml", kTypes);
  add_file(archive, "_rels/.rels", kRelations);
  add_file(archive, kModelFile, model);
  if (zip_close(archive) != 0 || zip_source_open(buffer) != 0) fail_to_write();
  zip_source_seek(buffer, 0, SEEK_END);
  std::string bytes(static_cast<std::size_t>(zip_source_tell(buffer)), '\0');
  zip_source_seek(buffer, 0, SEEK_SET);
  const zip_int64_t read = zip_source_read(buffer, bytes.data(), bytes.size());
  zip_source_close(buffer);
  if (read != static_cast<zip_int64_t>(bytes.size())) fail_to_write();
  return bytes;
}

}  // namespace multitetra

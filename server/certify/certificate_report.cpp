#include "server/certify/certificate_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/base/json.hpp"
#include "common/base/number_at_resolution.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/terminal.hpp"
#include "common/json/json_report.hpp"

namespace multitetra {
namespace {

using Row = std::vector<std::string>;

std::string digits(double value) {
  if (std::isinf(value)) return "infinite";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

// Formats lengths in world units and in voxels.
class Lengths {
 public:
  explicit Lengths(const DatasetInfo& grid)
      : voxel_(voxel_length(grid)), unit_(grid.meaning.length_unit) {}

  [[nodiscard]] std::string voxels(double world) const { return digits(world / voxel_); }
  [[nodiscard]] std::string text(double world) const {
    if (std::isinf(world)) return "infinite";
    const std::string unit = unit_.empty() ? "units" : printable(unit_);
    return digits(world / voxel_) + " voxels (" + digits(world) + " " + unit + ")";
  }

 private:
  double voxel_;
  std::string unit_;
};

// To a hundredth of a voxel.
std::string place_text(const Vec3& place, const Certificate& certificate) {
  const double resolution = voxel_length(certificate.grid) / 100;
  return number_at(place[0], resolution) + ", " + number_at(place[1], resolution) + ", " +
         number_at(place[2], resolution);
}

// Returns "allowed: 0.05 error + 0.054 lattice = 0.104 voxels (0.052 mm)".
std::string allowed_text(const Certificate& certificate, const CertifyOptions& options,
                         const Lengths& lengths) {
  double sum = *options.error;
  std::string parts = lengths.voxels(sum) + " error";
  const auto add = [&](double allowance, const char* name) {
    sum += allowance;
    if (allowance > 0) parts += " + " + lengths.voxels(allowance) + " " + name;
  };
  add(certificate.lattice_allowance, "lattice");
  add(certificate.rounding_allowance, "rounding of 32-bit coordinates");
  return "allowed: " + parts + " = " + lengths.text(sum);
}

std::string error_line(const Certificate& certificate, const CertifyOptions& options,
                       const Lengths& lengths) {
  const std::string allowed = options.error ? allowed_text(certificate, options, lengths) : "";
  switch (certificate.error) {
    case ErrorVerdict::kNotRequested:
      return "not requested (--error): no point of either surface is farther from the other than " +
             lengths.text(certificate.maximum_at_most());
    case ErrorVerdict::kProven:
      return "kept: no point of either surface is farther from the other than " +
             lengths.text(certificate.maximum_at_most()) + "; " + allowed;
    case ErrorVerdict::kUndecided:
      return "kept: all measured points are within " + lengths.text(certificate.maximum()) + "; " +
             allowed + ". The proven bound for all points is " +
             lengths.text(certificate.maximum_at_most());
    case ErrorVerdict::kExceeded:
      return "NOT KEPT: a point is " + lengths.text(certificate.maximum()) +
             " from the other surface; " + allowed;
  }
  return {};
}

std::string faults_text(const Certificate& certificate) {
  const ComponentFaults& faults = certificate.faults;
  if (faults.are_all_reversed) {
    return "all components are inside out: their triangles face high values. For meshes of "
           "programs that orient them so: --inside-out";
  }
  const bool is_reversed = faults.reversed > 0;
  return human_count_of(is_reversed ? faults.reversed : faults.misplaced, "component") +
         (is_reversed ? " inside out" : " on another side of a larger one") +
         (faults.place ? ", the first at " + place_text(*faults.place, certificate) : "");
}

std::string topology_line(const Certificate& certificate, const CertifyOptions& options) {
  if (options.within) return "not compared: only distances inside the box are";
  const bool is_kept = certificate.keeps_topology();
  if (!certificate.is_topology_required) {
    return std::string(is_kept ? "that of the full surface" : "different from the full surface") +
           ", which is allowed";
  }
  if (!is_kept) return "NOT KEPT: see the table";
  if (!certificate.keeps_components()) return "NOT KEPT: " + faults_text(certificate);
  return std::string(
             "kept: components, their orientation and Euler characteristic are those of the full "
             "surface") +
         (options.min_component > 0 ? ", without the components that --min-component leaves out"
                                    : "");
}

std::string watertight_text(const Certificate& certificate) {
  if (certificate.is_watertight()) return "yes";
  if (certificate.mesh.open_edges == 0 && certificate.mesh.nonmanifold_edges == 0) {
    return "yes, up to the border of the data";
  }
  return "NO";
}

std::string distances_text(const Certificate& certificate, const Lengths& lengths) {
  std::vector<Row> rows = {{"Distance", "at most", "found", "99 %", "mean"}};
  const auto add = [&](const std::string& name, const SurfaceDistance& d) {
    rows.push_back({name, lengths.text(d.maximum_at_most), lengths.text(d.maximum),
                    lengths.text(d.percentile_99), lengths.text(d.mean)});
  };
  const auto& [there, back] = certificate.distance;
  add("of the mesh from the full surface", there);
  add("of the full surface from the mesh", back);
  const bool is_there = there.maximum >= back.maximum;
  const std::uint64_t undecided = there.undecided + back.undecided;
  const std::string given_up =
      undecided == 0 ? ""
                     : human_count_of(undecided, "piece") +
                           " of triangles are undecided: the search ends before \"at most\" and "
                           "\"found\" meet.\n";
  return text_table(rows) + given_up + "The farthest point is on the " +
         (is_there ? "mesh" : "full surface") + ", at " +
         place_text((is_there ? there : back).farthest, certificate) + " in world coordinates.\n";
}

std::string topology_text(const Certificate& certificate) {
  std::vector<Row> rows = {{"Topology", "mesh", "full surface"}};
  const auto add = [&](const std::string& name, std::int64_t MeshTopology::*count) {
    const auto text = [&](const MeshTopology& of) {
      const std::int64_t value = of.*count;
      return (value < 0 ? "-" : "") + human_count(static_cast<std::uint64_t>(std::abs(value)));
    };
    rows.push_back({name, text(certificate.mesh), text(certificate.reference)});
  };
  const auto add_own = [&](const std::string& name, const std::string& value) {
    rows.push_back({name, value, ""});
  };
  add("components", &MeshTopology::components);
  add("Euler characteristic", &MeshTopology::euler_characteristic);
  const auto add_closed = [&](const std::string& name, std::int64_t ClosedComponents::*count) {
    rows.push_back(
        {name, human_count(static_cast<std::uint64_t>(certificate.closed.*count)),
         human_count(static_cast<std::uint64_t>(certificate.closed_of_reference.*count))});
  };
  add_closed("closed components that face outwards", &ClosedComponents::outwards);
  add_closed("closed components that face inwards (cavities)", &ClosedComponents::inwards);
  add("triangles", &MeshTopology::triangles);
  add("vertices", &MeshTopology::vertices);
  add("open edges on the border of the data", &MeshTopology::border_edges);
  add("open edges elsewhere", &MeshTopology::open_edges);
  add("non-manifold edges, or inconsistently oriented triangles", &MeshTopology::nonmanifold_edges);
  rows.push_back(
      {"non-manifold vertices",
       human_count(static_cast<std::uint64_t>(certificate.nonmanifold_vertices)),
       human_count(static_cast<std::uint64_t>(certificate.nonmanifold_vertices_of_reference))});
  add_own("degenerate triangles", human_count(certificate.degenerate_triangles));
  add_own("watertight", watertight_text(certificate));
  if (certificate.self_intersections) {
    const SelfIntersections& found = *certificate.self_intersections;
    add_own("triangles that intersect others", human_count(found.triangles));
    add_own("triangles with zero area", human_count(found.flat_triangles));
    if (found.triangles > 0) {
      return text_table(rows) + "A triangle that intersects others is at " +
             place_text(found.place, certificate) + " in world coordinates.\n";
    }
  } else {
    add_own("triangles that intersect others", "not counted (--self-intersections)");
  }
  return text_table(rows);
}

std::string missing_text(const Certificate& certificate) {
  const MissingComponents& missing = *certificate.missing;
  std::string text =
      "\n" + human_count(missing.count) + " of " +
      human_count_of(static_cast<std::uint64_t>(certificate.reference.components), "component") +
      " of the full surface, with diagonals up to " + digits(missing.largest_diagonal) +
      " samples, are not in the mesh; the others agree with it.";
  if (missing.min_component) {
    text += " If they were removed on purpose, compare without them: --min-component " +
            shortest_text(*missing.min_component) + ".";
  }
  return text + "\n";
}

std::string left_out_text(const Certificate& certificate, const CertifyOptions& options) {
  const LeftOutComponents& left_out = certificate.left_out;
  if (left_out.count == 0) return {};
  return "\n" + human_count_of(left_out.count, "component") + " of the full surface with up to " +
         digits(left_out.largest_diagonal) + " samples, not below --min-component " +
         shortest_text(options.min_component) +
         ", are not in the mesh: the allowed error may have moved them across this limit. "
         "Distances leave them out.\n";
}

// Suggests a cause of a failure.
std::string hint(const Certificate& certificate, const CertifyOptions& options,
                 const Lengths& lengths) {
  if (certificate.missing) return missing_text(certificate);
  if (certificate.suggestion) {
    return "\nThe mesh would be within " + lengths.text(certificate.suggestion->distance) +
           " of the full surface, where measured, with " + certificate.suggestion->option + ".\n";
  }
  if (certificate.error == ErrorVerdict::kExceeded && !options.allow_rounding &&
      certificate.maximum() <=
          *options.error + certificate.lattice_allowance + certificate.rounding) {
    return "\nThe excess is less than the rounding of the mesh's 32-bit coordinates, " +
           lengths.text(certificate.rounding) +
           " here, which --allow-rounding allows. PLY, OBJ and VTP files of `extract` have 64 bits "
           "where these are needed.\n";
  }
  const double rounded = lattice_rounding_world(certificate.grid, kDefaultLatticeResolution);
  if (certificate.error == ErrorVerdict::kExceeded && !options.lattice &&
      certificate.maximum() <= *options.error + rounded) {
    return "\nThe excess is less than the rounding of vertices in meshes of a server, which "
           "--lattice " +
           std::to_string(kDefaultLatticeResolution) + " allows.\n";
  }
  if (certificate.passes() || options.outside || certificate.vertices_beyond_data == 0) return {};
  return "\n" + human_count(certificate.vertices_beyond_data) +
         " vertices lie beyond the samples. If the dataset was prepared with --pad-value, --pad "
         "or "
         "other coordinates, repeat these options or compare with it: --volume DATASET.mtd.\n";
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const SurfaceDistance& distance, double voxel) {
  const auto in = [&](double unit) -> Json {
    return {{"maximum", number(distance.maximum / unit)},
            {"maximum_at_most", number(distance.maximum_at_most / unit)},
            {"percentile_99", number(distance.percentile_99 / unit)},
            {"mean", number(distance.mean / unit)}};
  };
  return {{"world", in(1)},
          {"voxel", in(voxel)},
          {"farthest_point", distance.farthest},
          {"samples", distance.samples},
          {"undecided_pieces", distance.undecided}};
}

Json json_of(const ClosedComponents& closed) {
  return {{"outwards", closed.outwards}, {"inwards", closed.inwards}};
}

Json error_json(const Certificate& certificate, const CertifyOptions& options, double voxel) {
  const bool is_requested = options.error.has_value();
  return {
      {"kept", is_requested ? Json(certificate.error != ErrorVerdict::kExceeded) : Json(nullptr)},
      {"proven", is_requested ? Json(certificate.error == ErrorVerdict::kProven) : Json(nullptr)},
      {"world", is_requested ? Json(*options.error) : Json(nullptr)},
      {"voxel", is_requested ? Json(*options.error / voxel) : Json(nullptr)},
      {"lattice_allowance_world", certificate.lattice_allowance},
      {"rounding_allowance_world", certificate.rounding_allowance},
      {"rounding_world", certificate.rounding}};
}

Json faults_json(const ComponentFaults& faults) {
  return {{"reversed", faults.reversed},
          {"misplaced", faults.misplaced},
          {"place", faults.place ? Json(*faults.place) : Json(nullptr)}};
}

Json missing_json(const Certificate& certificate) {
  if (!certificate.missing) return nullptr;
  const MissingComponents& missing = *certificate.missing;
  return {{"count", missing.count},
          {"largest_diagonal", missing.largest_diagonal},
          {"min_component", value_or_null(missing.min_component)}};
}

// In the coordinates of the mesh file.
Json box_json(const CertifyOptions& options) {
  if (!options.within) return nullptr;
  return Json::array({options.within->box.low, options.within->box.high});
}

const char* headline(const Certificate& certificate) {
  if (!certificate.passes()) return "NOT certified: ";
  if (certificate.error == ErrorVerdict::kNotRequested) return "Measured only: ";
  return certificate.error == ErrorVerdict::kUndecided ? "Kept where measured, not proven between: "
                                                       : "Certified: ";
}

Json digest_json(const std::string& digest) { return digest.empty() ? Json() : Json(digest); }

std::string digests_text(const CertifiedFiles& files) {
  std::vector<std::vector<std::string>> rows;
  if (!files.mesh_sha256.empty()) rows.push_back({"  SHA-256 of the mesh", files.mesh_sha256});
  if (!files.volume_sha256.empty())
    rows.push_back({"  SHA-256 of the volume", files.volume_sha256});
  return rows.empty() ? "" : "\n" + text_table(rows);
}

// Distances are between the surfaces as they were read.
std::string notices_text(const char* of, const std::vector<std::string>& notices) {
  std::string text = notices.empty() ? "" : std::string("\nOf the ") + of + " as it was read:\n";
  for (const std::string& notice : notices) {
    text += "  " + printable(notice, /*keeps_lines=*/false) + "\n";
  }
  return text;
}

// "partly (spacing along z is assumed)"; null: unknown.
Json geometry_json(const PhysicalMeaning& meaning) {
  const std::string text = geometry_text(meaning);
  return text.empty() ? Json(nullptr) : Json(text);
}

}  // namespace

std::string text_of(const Certificate& certificate, const CertifiedFiles& files,
                    const CertifyOptions& options) {
  const Lengths lengths(certificate.grid);
  std::vector<std::vector<std::string>> rows = {
      {"  error", error_line(certificate, options, lengths)},
      {"  topology", topology_line(certificate, options)}};
  if (has_assumed_spacing(certificate.grid.meaning)) {
    rows.push_back({"  geometry", printable(geometry_text(certificate.grid.meaning)) +
                                      ": lengths are not measured"});
  }
  return std::string(headline(certificate)) + printable(files.mesh) + ", for the surface of " +
         printable(files.volume) + " at isovalue " + shortest_text(options.isovalue) + ".\n" +
         text_table(rows) + "\n" + distances_text(certificate, lengths) + "\n" +
         topology_text(certificate) + digests_text(files) +
         notices_text("mesh", files.mesh_notices) + notices_text("volume", files.volume_notices) +
         left_out_text(certificate, options) + hint(certificate, options, lengths);
}

Json json_of(const Certificate& certificate, const CertifiedFiles& files,
             const CertifyOptions& options) {
  const double voxel = voxel_length(certificate.grid);
  Json mesh = json_of(certificate.mesh);
  mesh["degenerate_triangles"] = certificate.degenerate_triangles;
  mesh["vertices_beyond_data"] = certificate.vertices_beyond_data;
  mesh["nonmanifold_vertices"] = certificate.nonmanifold_vertices;
  mesh["closed_components"] = json_of(certificate.closed);
  Json reference = json_of(certificate.reference);
  reference["nonmanifold_vertices"] = certificate.nonmanifold_vertices_of_reference;
  reference["closed_components"] = json_of(certificate.closed_of_reference);
  Json json = {
      {"kept", certificate.passes()},
      {"mesh_file", files.mesh},
      {"volume", files.volume},
      {"mesh_sha256", digest_json(files.mesh_sha256)},
      {"volume_sha256", digest_json(files.volume_sha256)},
      {"isovalue", options.isovalue},
      {"geometry", geometry_json(certificate.grid.meaning)},
      {"mesh_notices", files.mesh_notices},
      {"volume_notices", files.volume_notices},
      {"error", error_json(certificate, options, voxel)},
      {"topology_kept", certificate.keeps_topology()},
      {"orientation_kept", certificate.faults.reversed == 0},
      {"components", faults_json(certificate.faults)},
      {"watertight", certificate.is_watertight()},
      {"distances",
       {{"mesh_to_full", json_of(certificate.distance.mesh_to_reference, voxel)},
        {"full_to_mesh", json_of(certificate.distance.reference_to_mesh, voxel)}}},
      {"mesh", std::move(mesh)},
      {"full_surface", std::move(reference)},
      {"missing_components", missing_json(certificate)},
      {"min_component", options.min_component},
      {"left_out_above_min_component",
       {{"count", certificate.left_out.count},
        {"largest_diagonal", certificate.left_out.largest_diagonal}}},
      {"fits_with", certificate.suggestion ? Json(certificate.suggestion->option) : Json(nullptr)},
      {"box", box_json(options)},
      {"self_intersections", nullptr}};
  if (certificate.self_intersections) {
    const SelfIntersections& found = *certificate.self_intersections;
    json["self_intersections"] = {{"triangles", found.triangles},
                                  {"pairs", found.pairs},
                                  {"flat_triangles", found.flat_triangles},
                                  {"place", found.place}};
  }
  return json;
}

}  // namespace multitetra

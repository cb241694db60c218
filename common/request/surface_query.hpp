// A request for surfaces as users write it, and the single table of its fields. Command-line
// options, HTTP query parameters and Python keyword arguments are generated from this table:
// --max-triangles, max_triangles= and max_triangles are one entry, parsed by one function.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/image/color_map.hpp"
#include "common/request/default_error.hpp"
#include "common/request/field_setters.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/mesh_codec.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

struct SurfaceQuery {
  std::vector<double> isovalues = {};  // One surface each; empty: the dataset's first suggestion.
  // Its isovalue is not used.
  IsosurfaceRequest request = {.error = kDefaultError, .simplify = true};
  // Set if the allowed error was given as a number or by name, respectively.
  bool has_error = false;
  bool has_quality = false;
  // The dataset whose values color the surfaces; empty: none.
  std::string color_by = {};
  std::optional<ScalarRequest::Limits> color_range = {};
  // Allows a dataset in another world.
  bool color_anyway = false;

  // The parameters of the output file.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  MeshCodec codec = MeshCodec::kNone;
  // In samples: removes components with a shorter diagonal; kLargestAlone: all but the largest.
  double min_component = 0;
  // Its range is set to that of the step's scalars.
  ColorScale colors = {.map = ColorMap::kViridis};
};

enum class FieldGroup {
  kSurface,
  kThresholds,  // Errors that differ from place to place.
  kSize,
  kColors,
  kFile,
};

[[nodiscard]] std::string_view title(FieldGroup group);

struct RequestField {
  std::string_view name;  // In snake_case.
  // The alternatives, "voxel|world", or the kind of value, "NUMBER"; empty: a switch.
  std::string_view value_syntax;
  std::string_view default_text;  // The default as text; empty: none.
  FieldGroup group;
  bool is_everyday;  // Listed by --help.
  bool is_repeatable;
  std::string_view help;  // One sentence, without range and default.
  FieldError (*set)(const RequestField& field, std::string_view text, SurfaceQuery& query);
};

// Returns all fields, in the order of the documentation.
[[nodiscard]] std::span<const RequestField> request_fields();

// Returns the error of a quality: draft, normal, fine and exact are 2, 0.5, 0.25 and 0 voxels.
[[nodiscard]] std::optional<double> quality_error_from(std::string_view name);

// Returns the validated requests for a dataset, one per isovalue. Each has the whole budget, which
// is still to be shared. Fails with kInvalidArgument or kLimitExceeded, naming the field.
[[nodiscard]] Result<std::vector<IsosurfaceRequest>> requests_for(const SurfaceQuery& query,
                                                                  const DatasetInfo& info);

// Returns the validated field that colors the surfaces, nullopt for none, or kInvalidArgument.
[[nodiscard]] Result<std::optional<ScalarRequest>> scalars_for(const SurfaceQuery& query);

}  // namespace multitetra

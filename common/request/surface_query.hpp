// A request for surfaces as people write it, and the one table of its fields. Options of commands,
// parameters of an HTTP query and keyword arguments in Python are made from this table:
// --max-triangles, max_triangles= and max_triangles are one entry, read by one function.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "common/image/color_map.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/default_error.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

struct SurfaceQuery {
  std::vector<double> isovalues = {};  // A surface for each; none: the dataset's first suggestion.
  IsosurfaceRequest request = {.error = kDefaultError, .simplify = true};  // Without its isovalue.
  bool has_error = false;  // Which of the two names for the allowed error are given.
  bool has_quality = false;
  // The dataset whose values color the surfaces; empty: none.
  std::string color_by = {};
  std::optional<ScalarRequest::Limits> color_range = {};
  bool color_anyway = false;  // Also where that dataset lies in another world.

  // About the file that is made of the surface.
  CoordinateSystem coordinates = CoordinateSystem::kWorld;
  double min_component = 0;  // Samples: components with a shorter diagonal are left out.
  ColorScale colors = {.map = ColorMap::kViridis};  // Its ends are those of the step's scalars.
};

enum class FieldGroup {
  kSurface,
  kThresholds,  // Errors that differ from place to place.
  kSize,
  kColors,
  kFile,
};

[[nodiscard]] std::string_view title(FieldGroup group);

// The error of a value, such as "must be voxel or world"; nullopt if nothing is.
using FieldError = std::optional<std::string>;

struct RequestField {
  std::string_view name;  // In snake_case.
  std::string_view
      form;  // The alternatives, "voxel|world", or what it is, "NUMBER"; empty: a switch.
  std::string_view usual;  // The default as text; empty: none.
  FieldGroup group;
  bool is_everyday;  // Whether --help lists it.
  bool is_repeatable;
  std::string_view help;  // One sentence, without range and default.
  FieldError (*set)(const RequestField& field, std::string_view text, SurfaceQuery& query);
};

// In the order of documentation.
[[nodiscard]] std::span<const RequestField> request_fields();

// Named errors: draft, normal, fine and exact, 2, 0.5, 0.25 and 0 voxels.
[[nodiscard]] std::optional<double> quality_error_from(std::string_view name);

// The requests for a dataset, one for each isovalue, checked as requests over the wire are; a
// budget is still that of all of them together. kInvalidArgument or kLimitExceeded, naming the
// field.
[[nodiscard]] Result<std::vector<IsosurfaceRequest>> requests_for(const SurfaceQuery& query,
                                                                  const DatasetInfo& info);

// The field that colors the surfaces, checked; nullopt: none. kInvalidArgument, naming the field.
[[nodiscard]] Result<std::optional<ScalarRequest>> scalars_for(const SurfaceQuery& query);

// Whether the dataset of color_by may color surfaces of another: it lies in the same world
// (same_world.hpp), or `color_anyway` is given. kInvalidArgument, with the reason.
[[nodiscard]] Result<void> check_colors(const SurfaceQuery& query, const DatasetInfo& surface,
                                        const DatasetInfo& values);

}  // namespace multitetra

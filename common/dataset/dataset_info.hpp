// The description of a dataset, from which a client can choose its requests.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/affine.hpp"
#include "common/dataset/display_window.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "common/dataset/series_member.hpp"
#include "common/mesh/mesh_checks.hpp"

namespace multitetra {

enum class SampleType { kU8, kI8, kU16, kI16, kF32 };

[[nodiscard]] std::string_view name(SampleType type);  // "u8", "i8", "u16", "i16", "f32"
[[nodiscard]] std::optional<SampleType> sample_type_from(std::string_view name);
[[nodiscard]] int bytes_per_sample(SampleType type);

// Calls `visitor` with a null pointer to the sample type: one dispatch for a whole pass.
template <typename Visitor>
decltype(auto) visit_type(SampleType type, Visitor&& visitor) {
  switch (type) {
    case SampleType::kU8:
      return visitor(static_cast<const std::uint8_t*>(nullptr));
    case SampleType::kI8:
      return visitor(static_cast<const std::int8_t*>(nullptr));
    case SampleType::kU16:
      return visitor(static_cast<const std::uint16_t*>(nullptr));
    case SampleType::kI16:
      return visitor(static_cast<const std::int16_t*>(nullptr));
    case SampleType::kF32:
      break;
  }
  return visitor(static_cast<const float*>(nullptr));
}

struct Histogram {
  double low = 0;   // The lower end of the first bin.
  double high = 0;  // The upper end of the last bin; bins have equal width.
  std::vector<std::uint64_t> counts;

  friend bool operator==(const Histogram&, const Histogram&) = default;
};

// The samples with a label's value in its label map.
struct LabelExtent {
  struct Place {  // In sample indices.
    std::array<std::int32_t, 3> least{};
    std::array<std::int32_t, 3> greatest{};
    Vec3 centroid{};

    friend bool operator==(const Place&, const Place&) = default;
  };
  std::uint64_t samples = 0;                  // At least 1.
  std::optional<Place> place = std::nullopt;  // Absent in datasets prepared by earlier releases.

  friend bool operator==(const LabelExtent&, const LabelExtent&) = default;
};

// The dataset stores samples without errors. They are not known to be smaller than infinite near
// the surface: replies hold all promises, with slightly more tetrahedra and cruder estimates.
inline constexpr const char* kMissingErrors = "errors";

struct DatasetInfo {
  std::string name;                    // UTF-8, 1 to 255 bytes, no '/' and no control characters.
  std::array<std::int32_t, 3> dims{};  // Samples along x, y, z; each at least 1.
  SampleType type = SampleType::kU8;
  Vec3 spacing = {1, 1, 1};  // World units between samples, > 0.
  Affine index_to_world;     // Sample index -> world: origin, directions and spacing.
  // The meaning of world coordinates and values.
  PhysicalMeaning meaning = {};
  double min = 0;  // The range of the samples that are not void.
  double max = 0;
  std::uint64_t void_samples = 0;  // The number of NaN samples, where there is no field.
  std::optional<double> outside;   // The value beyond the data; absent means void.
  std::int32_t margin = 0;         // Grid steps from the grid's origin to the first sample.
  // The grid has 2^grid_exponent steps per side.
  std::int32_t grid_exponent = 1;
  Histogram histogram;
  std::vector<double> suggested_isovalues;  // Best first.
  // Equal only if description, samples and stored errors are equal, and so replies; 0: unknown.
  std::uint64_t content_id = 0;
  std::optional<SeriesMember> member = std::nullopt;  // Absent if it belongs to no series.
  // The extent of the member's label; absent: unknown.
  std::optional<LabelExtent> label_extent = std::nullopt;
  // What the source recommends for showing the samples, such as the window of an OMERO channel.
  std::optional<DisplayWindow> display_window = std::nullopt;
  // What the dataset lacks: empty, or kMissingErrors.
  std::string missing = {};

  friend bool operator==(const DatasetInfo&, const DatasetInfo&) = default;
};

// Returns the exponent N >= 1 of the smallest grid that holds `dims` samples with `margin` grid
// steps around them.
[[nodiscard]] std::int32_t grid_exponent_for(const std::array<std::int32_t, 3>& dims,
                                             std::int32_t margin);

// Returns the length of "1 voxel" in world units: the smallest spacing.
[[nodiscard]] double voxel_length(const DatasetInfo& info);

// Maps grid coordinates to world coordinates: a shift by the margin, then index_to_world.
[[nodiscard]] Affine grid_to_world(const DatasetInfo& info);
// Maps grid coordinates to sample indices.
[[nodiscard]] Affine grid_to_index(const DatasetInfo& info);

// Returns the longest diagonal of a cell of eight samples, which is the longest edge of a
// tetrahedron of the finest level, in world units.
[[nodiscard]] double longest_cell_diagonal(const DatasetInfo& info);

// Returns the largest displacement of a vertex by rounding to the lattice, in world units: one
// lattice step along the longest edge, since vertices are never at the ends of their edges.
[[nodiscard]] double lattice_rounding_world(const DatasetInfo& info, int lattice_resolution);

// Returns the places where an isosurface of this dataset may end. With a value outside: at the
// faces of the grid. With void outside: at the last samples; in previews also further inside,
// because a tetrahedron that reaches beyond the data carries no surface. Such tetrahedra are at
// most `finest_spacing` or twice the tolerated flip's spacing long, and at least one step of that
// lies outside. Requires topology_tolerance >= 0 (grid steps) and finest_spacing a power of two.
[[nodiscard]] DataBorder data_border(const DatasetInfo& info, int lattice_resolution,
                                     double topology_tolerance, std::int32_t finest_spacing = 1);

}  // namespace multitetra

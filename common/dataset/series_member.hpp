// The place of a dataset in a series: datasets on the same grid, such as the times of a scan, the
// fields of a simulation, the labels of a segmentation. They have equal dims, spacing,
// index_to_world, margin, outside and space.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

// A label of a label map.
struct Label {
  double value = 0;       // In the label map: an integer, at most kMaxLabelValue in magnitude.
  std::string name = {};  // May be empty.
  std::optional<std::uint32_t> color = std::nullopt;  // 0xRRGGBB; absent if the file defines none.

  friend bool operator==(const Label&, const Label&) = default;
};

struct SeriesMember {
  std::string series;      // A valid dataset name.
  std::string field = {};  // The name in the source file; empty if the series has one field.
  // The time in time_unit; finite. Absent if the series has no times.
  std::optional<double> time = std::nullopt;
  // The unit of times, such as "s"; empty: unknown, and times are frame numbers.
  std::string time_unit = {};
  // The color in which the source shows the field, such as a microscope's channel, as 0xRRGGBB;
  // absent if it has none.
  std::optional<std::uint32_t> color = std::nullopt;
  // The label whose smooth field the dataset is; the boundary is at 0.5.
  std::optional<Label> label = std::nullopt;

  friend bool operator==(const SeriesMember&, const SeriesMember&) = default;
};

// The limit of names of fields and labels.
inline constexpr std::size_t kMaxMemberTextBytes = 255;
inline constexpr double kMaxLabelValue = 9007199254740992.0;  // 2^53, for either sign.

// Fails with kInvalidArgument, naming the field and the valid range, if a field is out of range.
[[nodiscard]] Result<void> check_member(const SeriesMember& member);

// Returns the color of the label, which is generated if its file has none, or of the field; nullopt
// if it has none.
[[nodiscard]] std::optional<std::uint32_t> display_color(const SeriesMember& member);

// Converts 0xdd8265 to "#dd8265" and back; nullopt for other texts.
[[nodiscard]] std::string color_text(std::uint32_t color);
[[nodiscard]] std::optional<std::uint32_t> color_from(std::string_view text);

}  // namespace multitetra

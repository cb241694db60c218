// The role of a dataset in its series: several datasets on the same grid, such as the times of a
// scan, the fields of a simulation, the labels of a segmentation. Each is a dataset of its own;
// dims, spacing, index_to_world, margin, outside and space are common to all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace multitetra {

// One label of a label map.
struct Label {
  double value = 0;       // In the label map: whole, of at most kMaxLabelValue.
  std::string name = {};  // May be empty.
  std::optional<std::uint32_t> color = std::nullopt;  // 0xRRGGBB; none: the file has none.

  friend bool operator==(const Label&, const Label&) = default;
};

struct SeriesMember {
  std::string series;      // Valid as a dataset's name.
  std::string field = {};  // The name in its file; empty: the only one.
  std::optional<double> time =
      std::nullopt;  // In time_unit; finite. None: not one of several times.
  // Such as "s"; empty: unknown, then times are numbers of frames.
  std::string time_unit = {};
  std::optional<Label> label =
      std::nullopt;  // Whose smooth field the dataset is; the boundary is at 0.5.

  friend bool operator==(const SeriesMember&, const SeriesMember&) = default;
};

// For names of fields and labels.
inline constexpr std::size_t kMaxMemberTextBytes = 255;
inline constexpr double kMaxLabelValue = 9007199254740992.0;  // 2^53; either sign.

// kInvalidArgument, with the field and what is allowed, unless every field is within its range.
[[nodiscard]] Result<void> check_member(const SeriesMember& member);

// "#dd8265" for 0xdd8265, and back; none for other texts.
[[nodiscard]] std::string color_text(std::uint32_t color);
[[nodiscard]] std::optional<std::uint32_t> color_from(std::string_view text);

}  // namespace multitetra

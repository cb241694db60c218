// Further contents of a source on the same grid: times, fields, and names of labels. Readers fill
// in what they know; `prepare` uses it for series.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/dataset/display_window.hpp"
#include "common/dataset/series_member.hpp"

namespace multitetra {

struct SourceTimes {
  std::int64_t count = 1;  // Number of times for VolumeChoice::time; 1 means no series.
  // One finite value per time; empty if unknown, in which case frames are counted.
  std::vector<double> at = {};
  // Unit of the times; empty if unknown.
  std::string unit = {};

  friend bool operator==(const SourceTimes&, const SourceTimes&) = default;
};

// One of several arrays or channels.
struct SourceField {
  std::string name;
  std::string array = {};  // Value for VolumeChoice::array; empty if not selected by array.
  std::optional<std::int64_t> channel = std::nullopt;  // Value for VolumeChoice::channel.
  std::int64_t components = 1;                         // Numbers per sample.
  std::optional<std::uint32_t> color = std::nullopt;   // 0xRRGGBB; absent if the source has none.

  friend bool operator==(const SourceField&, const SourceField&) = default;
};

// A label that the source names.
struct SourceLabel {
  Label label = {};  // Values are unique.
  // Value of the label in the samples.
  double stored = 0;
  // Component of the samples that contains the label.
  int layer = 0;

  friend bool operator==(const SourceLabel&, const SourceLabel&) = default;
};

// Something else in the source that can be chosen, not necessarily on the same grid.
struct SourceEntry {
  std::string kind;    // "array", "image", "series", "volume", "segment".
  std::string name;    // Its name or number in the source.
  std::string detail;  // Such as "8 x 6 x 5 u16"; may be empty.
  std::string option;  // That chooses it: "--array /a/b".

  friend bool operator==(const SourceEntry&, const SourceEntry&) = default;
};

struct VolumeContents {
  SourceTimes times = {};
  std::vector<SourceField> fields = {};  // In the source's order; empty if there is only one.
  // Samples may have others. Overlapping segments are in several layers, one component each.
  std::vector<SourceLabel> labels = {};
  // All that can be chosen by an option; empty if there is only one.
  std::vector<SourceEntry> entries = {};
  // Fields whose names are invalid.
  std::vector<std::string> unnamed = {};
  // The isovalue that the authors of the source recommend.
  std::optional<double> recommended_isovalue = std::nullopt;
  // Their window for showing the chosen field.
  std::optional<DisplayWindow> display_window = std::nullopt;

  friend bool operator==(const VolumeContents&, const VolumeContents&) = default;
};

inline constexpr std::size_t kMaxSourceMembers = 32'768;  // Maximum members of each kind.

// Returns `count` times from `first`, `step` apart, in `unit`; unknown times if these values are
// invalid, as from programs that leave the fields at 0.
[[nodiscard]] SourceTimes even_times(std::int64_t count, double first, double step,
                                     std::string_view unit);

// Converts spellings of seconds and their fractions ("sec", "second", "seconds": "s"). Returns
// others unchanged, or empty if they are not units.
[[nodiscard]] std::string time_unit_from(std::string_view text);

// Returns `text` if it is a valid name, else nothing: UTF-8 without control characters, at most
// kMaxMemberTextBytes.
[[nodiscard]] std::string member_name_from(std::string_view text);

[[nodiscard]] bool have_layers(const std::vector<SourceLabel>& labels);

// For packed.hpp.
inline auto fields(Label& label) { return std::tie(label.value, label.name, label.color); }
inline auto fields(SourceTimes& times) { return std::tie(times.count, times.at, times.unit); }
inline auto fields(SourceField& field) {
  return std::tie(field.name, field.array, field.channel, field.components, field.color);
}
inline auto fields(SourceLabel& label) { return std::tie(label.label, label.stored, label.layer); }
inline auto fields(SourceEntry& entry) {
  return std::tie(entry.kind, entry.name, entry.detail, entry.option);
}
inline auto fields(VolumeContents& contents) {
  return std::tie(contents.times, contents.fields, contents.labels, contents.entries,
                  contents.unnamed, contents.recommended_isovalue, contents.display_window);
}

}  // namespace multitetra

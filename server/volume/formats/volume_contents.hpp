// The contents of a source besides one volume, on the same grid: times, fields, and the
// names of labels. Readers fill in what they know; `prepare` reads it for series.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/request/series_member.hpp"

namespace multitetra {

struct SourceTimes {
  std::int64_t count = 1;  // The number of times for VolumeChoice::time; 1: no series.
  // One for each, finite; empty: unknown, then frames are counted.
  std::vector<double> at = {};
  // The unit of these; empty: unknown.
  std::string unit = {};

  friend bool operator==(const SourceTimes&, const SourceTimes&) = default;
};

// One of several arrays or channels.
struct SourceField {
  std::string name;
  std::string array = {};  // For VolumeChoice::array; empty: not by array.
  std::optional<std::int64_t> channel = std::nullopt;  // For VolumeChoice::channel.
  std::int64_t components = 1;                         // Numbers of a sample.

  friend bool operator==(const SourceField&, const SourceField&) = default;
};

// A label that the source names.
struct SourceLabel {
  Label label = {};  // No two have the same value.
  // The value of the label in the samples.
  double stored = 0;
  // The component of the samples that has the label.
  int layer = 0;

  friend bool operator==(const SourceLabel&, const SourceLabel&) = default;
};

struct VolumeContents {
  SourceTimes times = {};
  std::vector<SourceField> fields = {};  // As the source orders them; none: it has one only.
  // Others may occur. Segments that overlap lie in several layers, each a component of the samples.
  std::vector<SourceLabel> labels = {};
  // A field whose name is not valid as one.
  std::vector<std::string> unnamed = {};
  // The isovalue that the authors of the source recommend.
  std::optional<double> recommended_isovalue = std::nullopt;

  friend bool operator==(const VolumeContents&, const VolumeContents&) = default;
};

inline constexpr std::size_t kMostSourceMembers = 32'768;  // The most members of each kind.

// `count` times from `first` on, `step` apart, in `unit`; empty where these are no times, as
// written by programs that leave the fields at 0.
[[nodiscard]] SourceTimes even_times(std::int64_t count, double first, double step,
                                     std::string_view unit);

// Seconds and their parts under one name ("sec", "second", "seconds": "s"); others as they are,
// empty when they are no units.
[[nodiscard]] std::string time_unit_from(std::string_view text);

// `text` as far as it can be a name: nothing, where it is no UTF-8 without control characters of at
// most kMaxMemberTextBytes.
[[nodiscard]] std::string member_name_from(std::string_view text);

[[nodiscard]] bool have_layers(const std::vector<SourceLabel>& labels);

// For another process, and back. Requires what members_text returned.
[[nodiscard]] std::string members_text(const VolumeContents& members);
[[nodiscard]] VolumeContents members_from(std::string_view text);

}  // namespace multitetra

#include "server/volume/formats/detail/segment_names.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"

namespace multitetra {
namespace {

struct Segment {
  std::string name;
  std::optional<std::int64_t> value;
  std::optional<std::uint32_t> color;
  std::int64_t layer = 0;
};

// Parses three numbers from 0 to 1.
std::optional<std::uint32_t> color_of_shares(const std::string& text) {
  const std::vector<double> shares = finite_numbers(text);
  if (shares.size() != 3) return std::nullopt;
  std::uint32_t color = 0;
  for (const double share : shares) {
    if (!(share >= 0 && share <= 1)) return std::nullopt;
    color = color << 8 | static_cast<std::uint32_t>(std::lround(255 * share));
  }
  return color;
}

// Parses "Segment12_Name:=liver" to 12, "Name", "liver".
void add_line(std::string_view line, std::map<std::int64_t, Segment>& segments) {
  constexpr std::string_view kKey = "Segment";
  const std::size_t value_at = line.find(":=");
  if (!line.starts_with(kKey) || value_at == std::string_view::npos) return;
  const std::string_view key = line.substr(kKey.size(), value_at - kKey.size());
  const std::size_t under = key.find('_');
  if (under == std::string_view::npos) return;
  const std::optional<std::int64_t> number = integer(key.substr(0, under));
  if (!number || *number < 0 || segments.size() >= kMaxSourceMembers) return;
  Segment& segment = segments[*number];
  const std::string_view what = key.substr(under + 1);
  const std::string value(trimmed(line.substr(value_at + 2)));
  if (what == "Name") segment.name = member_name_from(value);
  if (what == "LabelValue") segment.value = integer(value);
  if (what == "Color") segment.color = color_of_shares(value);
  if (what == "Layer") segment.layer = integer(value).value_or(-1);
}

}  // namespace

std::vector<SourceLabel> segments_in(std::string_view header, std::int64_t max_layers) {
  std::map<std::int64_t, Segment> segments;
  while (!header.empty()) add_line(take_line(header), segments);
  std::vector<SourceLabel> labels;
  std::set<std::pair<std::int64_t, std::int64_t>> taken;  // Layers and values.
  for (auto& [number, segment] : segments) {
    if (!segment.value || segment.layer < 0 || segment.layer >= max_layers) continue;
    if (!taken.emplace(segment.layer, *segment.value).second) continue;
    const auto stored = static_cast<double>(*segment.value);
    Label label{.value = stored, .name = std::move(segment.name), .color = segment.color};
    if (!check_member({.series = "segments", .label = label})) continue;
    labels.push_back(
        {.label = std::move(label), .stored = stored, .layer = static_cast<int>(segment.layer)});
  }
  if (!have_layers(labels)) return labels;
  double number = 0;
  for (SourceLabel& label : labels) label.label.value = ++number;
  return labels;
}

void check_layers(const std::filesystem::path& file, const std::vector<SourceLabel>& labels,
                  std::int64_t layers, const VolumeChoice& choice) {
  if (layers == 1 || choice.component != ComponentChoice() || choice.first) return;
  fail_reading(file,
               "it is a segmentation: " + std::to_string(labels.size()) + " segments in " +
                   std::to_string(layers) + " layers, because some overlap",
               "Prepare each segment with --label all -o FOLDER/, or one layer with --component, "
               "from 0");
}

}  // namespace multitetra

#include "common/cli/human_units.hpp"

#include <array>
#include <cstdio>
#include <string_view>

#include "common/base/number_at_resolution.hpp"
#include "common/dataset/tissues.hpp"

namespace multitetra {
namespace {

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace

std::string human_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  double value = static_cast<double>(bytes) / 1024;
  const char* unit = "KiB";
  for (const char* larger : {"MiB", "GiB", "TiB"}) {
    if (value < 1024) break;
    value /= 1024;
    unit = larger;
  }
  return format("%.1f %s", value, unit);
}

std::string human_count(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ' ');
  return digits;
}

std::string human_count_of(std::uint64_t count, const std::string& noun) {
  return human_count(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string human_speed(double per_second) {
  return per_second < 10 ? format("%.2g", per_second)
                         : human_count(static_cast<std::uint64_t>(per_second));
}

std::string human_seconds(double seconds) {
  if (seconds < 0.00995) return format("%.1f ms", 1000 * seconds);
  if (seconds < 0.9995) return format("%.0f ms", 1000 * seconds);
  if (seconds < 59.95) return format(seconds < 9.995 ? "%.2f s" : "%.1f s", seconds);
  const auto whole = static_cast<long long>(seconds + 0.5);
  if (whole < 3600) return format("%lld min %02lld s", whole / 60, whole % 60);
  return format("%lld h %02lld min", whole / 3600, whole % 3600 / 60);
}

std::string human_number(double value) { return format("%g", value); }

std::string human_value(double value, const DatasetInfo& info) {
  return number_at(value, 1e-5 * (info.max - info.min));
}

std::string human_place(const Vec3& place, double voxel_length) {
  const double resolution = voxel_length / 100;
  return number_at(place[0], resolution) + " " + number_at(place[1], resolution) + " " +
         number_at(place[2], resolution);
}

std::string human_length(double length, const std::string& unit) {
  const std::string number = human_number(length);
  return number + " " + (!unit.empty() ? unit : number == "1" ? "unit" : "units");
}

std::string human_error(double world, ErrorUnit unit, const DatasetInfo& info) {
  const std::string length = human_length(world, info.meaning.length_unit);
  if (unit == ErrorUnit::kWorld) return length;
  const std::string voxels = human_number(world / voxel_length(info));
  return voxels + (voxels == "1" ? " voxel (" : " voxels (") + length + ")";
}

std::string human_suggestions(const DatasetInfo& info) {
  std::string text;
  for (const double isovalue : info.suggested_isovalues) {
    const std::string_view tissue = tissue_at(isovalue, info);
    text += (text.empty() ? "" : ", ") + human_value(isovalue, info);
    if (!tissue.empty()) text.append(" (").append(tissue).append(")");
  }
  return text.empty() ? "none" : text;
}

std::string human_member(const SeriesMember& member) {
  std::string text = "\"" + member.series + "\"";
  if (!member.field.empty()) text += ", field " + member.field;
  if (member.time) {
    text += ", time " + number_at(*member.time, /*resolution=*/0);
    if (!member.time_unit.empty()) text += " " + member.time_unit;
  }
  if (member.color) text += ", " + color_text(*member.color);
  if (!member.label) return text;
  const Label& label = *member.label;
  text += ", label " + std::to_string(static_cast<std::int64_t>(label.value));
  const std::string color = label.color ? color_text(*label.color) : std::string();
  const std::string between = label.name.empty() || color.empty() ? "" : ", ";
  const std::string known = label.name + between + color;
  return known.empty() ? text : text + " (" + known + ")";
}

}  // namespace multitetra

#include "server/volume/detail/reader_messages.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/base/utf8.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "common/sandbox/packed.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxText = 4096;  // Of entries and notes that are only shown.

bool is_valid(const VolumeHeader& header) {
  const auto is_finite = [](const Vec3& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
  };
  const Affine& map = header.index_to_world;
  return std::all_of(header.dims.begin(), header.dims.end(),
                     [](std::int32_t side) { return side >= 1 && side <= kMaxSide; }) &&
         header.type >= SampleType::kU8 && header.type <= SampleType::kF32 &&
         is_finite(header.spacing) &&
         *std::min_element(header.spacing.begin(), header.spacing.end()) > 0 &&
         std::all_of(map.columns.begin(), map.columns.end(), is_finite) &&
         is_finite(map.translation) && header.meaning.space >= WorldSpace::kUnnamed &&
         header.meaning.space <= WorldSpace::kRas && is_unit_text(header.meaning.length_unit) &&
         is_unit_text(header.meaning.value_unit) &&
         header.meaning.geometry >= GeometryBasis::kUnknown &&
         header.meaning.geometry <= GeometryBasis::kAssumed &&
         is_unit_text(header.meaning.assumed) && header.values.size() <= kMaxText;
}

bool is_valid(const SourceTimes& times) {
  return times.count >= 1 &&
         (times.at.empty() || times.at.size() == static_cast<std::uint64_t>(times.count)) &&
         std::all_of(times.at.begin(), times.at.end(), [](double t) { return std::isfinite(t); }) &&
         is_unit_text(times.unit);
}

bool is_valid(const SourceField& field) {
  return member_name_from(field.name) == field.name && field.array.size() <= kMaxText &&
         field.channel.value_or(0) >= 0 && field.components >= 1 &&
         field.color.value_or(0) <= 0xFFFFFF;
}

bool are_valid(const std::vector<SourceLabel>& labels) {
  std::set<double> values;
  return std::all_of(labels.begin(), labels.end(), [&](const SourceLabel& one) {
    return check_member({.series = "labels", .label = one.label}).has_value() &&
           std::isfinite(one.stored) && one.layer >= 0 && one.layer < kMaxComponents &&
           values.insert(one.label.value).second;
  });
}

bool is_valid(const SourceEntry& entry) {
  return std::max({entry.kind.size(), entry.name.size(), entry.detail.size(),
                   entry.option.size()}) <= kMaxText;
}

bool is_valid(const VolumeContents& contents) {
  const auto all_valid = [](const auto& values) {
    return values.size() <= kMaxSourceMembers &&
           std::all_of(values.begin(), values.end(), [](const auto& one) { return is_valid(one); });
  };
  return is_valid(contents.times) && all_valid(contents.fields) &&
         contents.labels.size() <= kMaxSourceMembers && are_valid(contents.labels) &&
         all_valid(contents.entries) && contents.unnamed.size() <= kMaxSourceMembers &&
         std::isfinite(contents.recommended_isovalue.value_or(0)) &&
         (!contents.display_window || is_valid(*contents.display_window));
}

}  // namespace

std::string header_text(const VolumeHeader& header) {
  return packed_values(header.dims, header.type, header.spacing, header.index_to_world,
                       header.meaning.space, header.meaning.length_unit, header.meaning.value_unit,
                       header.meaning.geometry, header.meaning.assumed, header.values);
}

std::optional<VolumeHeader> header_from(std::string_view bytes) {
  VolumeHeader header;
  const bool is_whole =
      unpack_all(bytes, header.dims, header.type, header.spacing, header.index_to_world,
                 header.meaning.space, header.meaning.length_unit, header.meaning.value_unit,
                 header.meaning.geometry, header.meaning.assumed, header.values);
  return is_whole && is_valid(header) ? std::optional(std::move(header)) : std::nullopt;
}

std::string contents_text(const VolumeContents& contents) { return packed_values(contents); }

std::optional<VolumeContents> contents_from(std::string_view bytes) {
  VolumeContents contents;
  if (!unpack_all(bytes, contents)) return std::nullopt;
  SourceTimes& times = contents.times;
  if (times.at.size() != static_cast<std::uint64_t>(times.count)) times.at.clear();
  return is_valid(contents) ? std::optional(std::move(contents)) : std::nullopt;
}

}  // namespace multitetra

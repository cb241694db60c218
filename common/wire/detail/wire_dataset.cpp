#include "common/wire/detail/wire_dataset.hpp"

#include <cmath>

namespace multitetra::wire {
namespace {

constexpr std::size_t kMaxHistogramBins = 65536;
constexpr std::size_t kMaxSuggestedIsovalues = 256;

Histogram read(const v1::Histogram& wire, FieldChecks& checks) {
  checks.finite("DatasetInfo.histogram.low", wire.low());
  checks.finite("DatasetInfo.histogram.high", wire.high());
  checks.require(wire.low() <= wire.high(), "DatasetInfo.histogram.high",
                 "must be at least its low end.");
  checks.at_most("DatasetInfo.histogram.counts", static_cast<std::size_t>(wire.counts_size()),
                 kMaxHistogramBins, "bins");
  return {.low = wire.low(),
          .high = wire.high(),
          .counts = {wire.counts().begin(), wire.counts().end()}};
}

// Reads dims, spacing, index_to_world, margin and grid.
void read_places(const v1::DatasetInfo& wire, DatasetInfo& info, FieldChecks& checks) {
  checks.exactly("DatasetInfo.dims", wire.dims_size(), 3);
  checks.exactly("DatasetInfo.spacing", wire.spacing_size(), 3);
  checks.exactly("DatasetInfo.index_to_world", wire.index_to_world_size(), 12);
  checks.integer("DatasetInfo.margin", wire.margin(), 0, kMaxGridSteps / 2);
  checks.integer("DatasetInfo.grid_exponent", wire.grid_exponent(), 1, kMaxGridExponent);
  if (checks.first()) return;
  std::uint64_t samples = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    checks.integer("DatasetInfo.dims", wire.dims(axis), 1, kMaxGridSteps + 1);
    info.dims[at] = static_cast<std::int32_t>(wire.dims(axis));
    samples *= wire.dims(axis);
    checks.require(std::isfinite(wire.spacing(axis)) && wire.spacing(axis) > 0,
                   "DatasetInfo.spacing", "must be finite and greater than 0 on every axis.");
    info.spacing[at] = wire.spacing(axis);
    for (int row = 0; row < 3; ++row) {
      info.index_to_world.columns[at][static_cast<std::size_t>(row)] =
          wire.index_to_world(3 * axis + row);
    }
    info.index_to_world.translation[at] = wire.index_to_world(9 + axis);
  }
  for (const double number : wire.index_to_world()) {
    checks.finite("DatasetInfo.index_to_world", number);
  }
  if (checks.first()) return;
  checks.integer("DatasetInfo.void_samples", wire.void_samples(), 0, samples);
  info.margin = static_cast<std::int32_t>(wire.margin());
  info.grid_exponent = static_cast<std::int32_t>(wire.grid_exponent());
  checks.require(info.grid_exponent >= grid_exponent_for(info.dims, info.margin),
                 "DatasetInfo.grid_exponent", "is too small for the samples and the margin.");
}

void write(const SeriesMember& member, v1::SeriesMember& wire) {
  wire.set_series(member.series);
  wire.set_field(member.field);
  if (member.time) wire.set_time(*member.time);
  wire.set_time_unit(member.time_unit);
  if (member.color) wire.set_color(*member.color);
  if (!member.label) return;
  wire.mutable_label()->set_value(member.label->value);
  wire.mutable_label()->set_name(member.label->name);
  if (member.label->color) wire.mutable_label()->set_color(*member.label->color);
}

void write(const LabelExtent& extent, v1::Label& wire) {
  wire.set_samples(extent.samples);
  if (!extent.place) return;
  for (const auto& corner : {extent.place->least, extent.place->greatest}) {
    for (const std::int32_t index : corner) wire.add_box(static_cast<std::uint32_t>(index));
  }
  for (const double index : extent.place->centroid) wire.add_centroid(index);
}

std::optional<LabelExtent> read_extent(const v1::Label& wire, const DatasetInfo& info,
                                       FieldChecks& checks) {
  std::uint64_t all = 1;
  for (const std::int32_t side : info.dims) all *= static_cast<std::uint64_t>(side);
  checks.integer("DatasetInfo.member.label.samples", wire.samples(), 0, all);
  if (wire.samples() == 0) return std::nullopt;
  LabelExtent extent{.samples = wire.samples()};
  if (wire.box().empty() && wire.centroid().empty()) return extent;
  checks.exactly("DatasetInfo.member.label.box", wire.box_size(), 6);
  checks.exactly("DatasetInfo.member.label.centroid", wire.centroid_size(), 3);
  if (checks.first()) return std::nullopt;
  LabelExtent::Place& place = extent.place.emplace(LabelExtent::Place{});
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    const std::uint32_t least = wire.box(axis);
    const std::uint32_t greatest = wire.box(3 + axis);
    checks.require(least <= greatest && greatest < static_cast<std::uint32_t>(info.dims[at]),
                   "DatasetInfo.member.label.box", "must be sample indices, the smallest first.");
    place.least[at] = static_cast<std::int32_t>(least);
    place.greatest[at] = static_cast<std::int32_t>(greatest);
    place.centroid[at] = wire.centroid(axis);
    checks.require(place.centroid[at] >= least && place.centroid[at] <= greatest,
                   "DatasetInfo.member.label.centroid", "must be inside the box.");
  }
  return extent;
}

SeriesMember read(const v1::SeriesMember& wire, FieldChecks& checks) {
  SeriesMember member{
      .series = wire.series(), .field = wire.field(), .time_unit = wire.time_unit()};
  if (wire.has_time()) member.time = wire.time();
  if (wire.has_color()) member.color = wire.color();
  if (wire.has_label()) {
    member.label = {.value = wire.label().value(), .name = wire.label().name()};
    if (wire.label().has_color()) member.label->color = wire.label().color();
  }
  if (const auto checked = check_member(member); !checked) {
    checks.fail(checked.error().code, "DatasetInfo." + checked.error().text);
  }
  return member;
}

}  // namespace

void write_dataset(const DatasetInfo& info, v1::DatasetInfo& wire) {
  wire.set_name(info.name);
  for (const std::int32_t samples : info.dims) wire.add_dims(static_cast<std::uint32_t>(samples));
  wire.set_type(to_wire<v1::SampleType>(info.type));
  for (const double length : info.spacing) wire.add_spacing(length);
  for (const Vec3& column : info.index_to_world.columns) {
    for (const double number : column) wire.add_index_to_world(number);
  }
  for (const double number : info.index_to_world.translation) wire.add_index_to_world(number);
  wire.set_min(info.min);
  wire.set_max(info.max);
  wire.set_void_samples(info.void_samples);
  if (info.outside) wire.set_outside(*info.outside);
  wire.set_margin(static_cast<std::uint32_t>(info.margin));
  wire.set_grid_exponent(static_cast<std::uint32_t>(info.grid_exponent));
  wire.mutable_histogram()->set_low(info.histogram.low);
  wire.mutable_histogram()->set_high(info.histogram.high);
  wire.mutable_histogram()->mutable_counts()->Assign(info.histogram.counts.begin(),
                                                     info.histogram.counts.end());
  wire.mutable_suggested_isovalues()->Assign(info.suggested_isovalues.begin(),
                                             info.suggested_isovalues.end());
  wire.set_content_id(info.content_id);
  wire.set_space(to_wire<v1::WorldSpace>(info.meaning.space));
  wire.set_length_unit(info.meaning.length_unit);
  wire.set_value_unit(info.meaning.value_unit);
  wire.set_geometry(to_wire<v1::GeometryBasis>(info.meaning.geometry));
  wire.set_assumed(info.meaning.assumed);
  if (info.member) write(*info.member, *wire.mutable_member());
  if (info.member && info.member->label && info.label_extent) {
    write(*info.label_extent, *wire.mutable_member()->mutable_label());
  }
  if (info.display_window) {
    wire.mutable_display_window()->set_low(info.display_window->low);
    wire.mutable_display_window()->set_high(info.display_window->high);
  }
}

DatasetInfo read_dataset(const v1::DatasetInfo& wire, FieldChecks& checks) {
  DatasetInfo info;
  checks.dataset_name("DatasetInfo.name", wire.name());
  info.name = wire.name();
  info.type = checks.enumerator<SampleType>("DatasetInfo.type", wire.type(), SampleType::kF32, {});
  read_places(wire, info, checks);
  checks.finite("DatasetInfo.min", wire.min());
  checks.finite("DatasetInfo.max", wire.max());
  checks.require(wire.min() <= wire.max(), "DatasetInfo.max", "must be at least min.");
  info.min = wire.min();
  info.max = wire.max();
  info.void_samples = wire.void_samples();
  if (wire.has_outside()) {
    checks.finite("DatasetInfo.outside", wire.outside());
    info.outside = wire.outside();
  }
  info.histogram = read(wire.histogram(), checks);
  checks.at_most("DatasetInfo.suggested_isovalues",
                 static_cast<std::size_t>(wire.suggested_isovalues_size()), kMaxSuggestedIsovalues,
                 "values");
  for (const double value : wire.suggested_isovalues()) {
    checks.finite("DatasetInfo.suggested_isovalues", value);
    info.suggested_isovalues.push_back(value);
  }
  info.content_id = wire.content_id();
  checks.unit("DatasetInfo.length_unit", wire.length_unit());
  checks.unit("DatasetInfo.value_unit", wire.value_unit());
  checks.unit("DatasetInfo.assumed", wire.assumed());
  info.meaning = {.space = checks.enumerator<WorldSpace>("DatasetInfo.space", wire.space(),
                                                         WorldSpace::kRas, WorldSpace::kUnnamed),
                  .length_unit = wire.length_unit(),
                  .value_unit = wire.value_unit(),
                  .geometry = checks.enumerator<GeometryBasis>(
                      "DatasetInfo.geometry", wire.geometry(), GeometryBasis::kAssumed,
                      GeometryBasis::kUnknown),
                  .assumed = wire.assumed()};
  if (wire.has_member()) info.member = read(wire.member(), checks);
  if (wire.member().has_label() && !checks.first()) {
    info.label_extent = read_extent(wire.member().label(), info, checks);
  }
  if (wire.has_display_window()) {
    info.display_window = {.low = wire.display_window().low(),
                           .high = wire.display_window().high()};
    checks.require(is_valid(*info.display_window), "DatasetInfo.display_window",
                   "must be two finite values, the smaller first.");
  }
  return info;
}

}  // namespace multitetra::wire

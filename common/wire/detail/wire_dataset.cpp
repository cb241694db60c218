#include "common/wire/detail/wire_dataset.hpp"

#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "common/dataset/dataset_fields.hpp"
#include "common/wire/detail/wire_vectors.hpp"

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

// ---- fields of DatasetInfo

// The accessors of a field in the message.
#define MULTITETRA_ACCESS(key, member, help)                                  \
  struct key##_access {                                                       \
    static decltype(auto) get(const auto& wire) { return wire.key(); }        \
    static bool has(const auto& wire) { return wire.has_##key(); }            \
    static void set(auto& wire, const auto& value) { wire.set_##key(value); } \
    static void add(auto& wire, const auto& value) { wire.add_##key(value); } \
    static auto& part(auto& wire) { return *wire.mutable_##key(); }           \
  };
MULTITETRA_DATASET_FIELDS(MULTITETRA_ACCESS)
#undef MULTITETRA_ACCESS

template <typename Access, typename Value>
void write_field(Access access, const Value& value, v1::DatasetInfo& wire) {
  if constexpr (std::is_enum_v<Value>) {
    Access::set(wire, to_wire<std::remove_cvref_t<decltype(Access::get(wire))>>(value));
  } else if constexpr (std::is_same_v<Value, std::int32_t>) {
    Access::set(wire, static_cast<std::uint32_t>(value));
  } else if constexpr (std::is_same_v<Value, Affine>) {
    for (const Vec3& column : value.columns) write_field(access, column, wire);
    write_field(access, value.translation, wire);
  } else if constexpr (std::is_same_v<Value, Histogram>) {
    Access::part(wire).set_low(value.low);
    Access::part(wire).set_high(value.high);
    Access::part(wire).mutable_counts()->Assign(value.counts.begin(), value.counts.end());
  } else if constexpr (std::is_same_v<Value, std::array<std::int32_t, 3>>) {
    for (const std::int32_t side : value) Access::add(wire, static_cast<std::uint32_t>(side));
  } else if constexpr (std::is_same_v<Value, Vec3> || std::is_same_v<Value, std::vector<double>>) {
    for (const double number : value) Access::add(wire, number);
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    if (value) Access::set(wire, *value);
  } else if constexpr (std::is_same_v<Value, std::optional<DisplayWindow>>) {
    if (!value) return;
    Access::part(wire).set_low(value->low);
    Access::part(wire).set_high(value->high);
  } else if constexpr (std::is_same_v<Value, std::optional<SeriesMember>>) {
    if (value) write(*value, Access::part(wire));
  } else {
    Access::set(wire, value);
  }
}

// Reads numbers, at most as many as there is room for.
void read_numbers(std::string_view name, const Numbers& wire, std::span<double> numbers,
                  FieldChecks& checks) {
  checks.exactly(name, wire.size(), static_cast<int>(numbers.size()));
  for (const double number : wire) checks.finite(name, number);
  if (!checks.first()) std::copy(wire.begin(), wire.end(), numbers.begin());
}

template <typename Access, typename Value>
void read_field(Access, std::string_view name, const v1::DatasetInfo& wire, Value& value,
                FieldChecks& checks) {
  const auto& from = Access::get(wire);
  if constexpr (std::is_same_v<Access, name_access>) {
    value = from;
    checks.dataset_name(name, from);
  } else if constexpr (std::is_same_v<Value, std::string>) {
    value = from;
    checks.unit(name, from);
  } else if constexpr (std::is_same_v<Value, double>) {
    value = from;
    checks.finite(name, value);
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    if (!Access::has(wire)) return;
    value = from;
    checks.finite(name, from);
  } else if constexpr (std::is_same_v<Value, std::int32_t>) {
    checks.integer(name, from, 0, std::numeric_limits<std::int32_t>::max());
    value = static_cast<std::int32_t>(from);
  } else if constexpr (std::is_same_v<Value, SampleType>) {
    value = checks.enumerator<SampleType>(name, from, SampleType::kF32, {});
  } else if constexpr (std::is_same_v<Value, WorldSpace>) {
    value = checks.enumerator<WorldSpace>(name, from, WorldSpace::kRas, WorldSpace::kUnnamed);
  } else if constexpr (std::is_same_v<Value, GeometryBasis>) {
    value = checks.enumerator<GeometryBasis>(name, from, GeometryBasis::kAssumed,
                                             GeometryBasis::kUnknown);
  } else if constexpr (std::is_same_v<Value, std::array<std::int32_t, 3>>) {
    checks.exactly(name, from.size(), 3);
    for (const std::uint32_t side : from) checks.integer(name, side, 1, kMaxGridSteps + 1);
    if (!checks.first()) std::copy(from.begin(), from.end(), value.begin());
  } else if constexpr (std::is_same_v<Value, Vec3>) {
    read_numbers(name, from, value, checks);
  } else if constexpr (std::is_same_v<Value, Affine>) {
    std::array<double, 12> numbers{};
    read_numbers(name, from, numbers, checks);
    const auto column = [&](std::size_t i) {
      return Vec3{numbers[i], numbers[i + 1], numbers[i + 2]};
    };
    value = {.columns = {column(0), column(3), column(6)}, .translation = column(9)};
  } else if constexpr (std::is_same_v<Value, std::vector<double>>) {
    for (const double number : from) checks.finite(name, number);
    value.assign(from.begin(), from.end());
  } else if constexpr (std::is_same_v<Value, std::optional<DisplayWindow>>) {
    if (!Access::has(wire)) return;
    value = {.low = from.low(), .high = from.high()};
    checks.require(is_valid(*value), name, "must be two finite values, the smaller first.");
  } else if constexpr (std::is_same_v<Value, Histogram>) {
    value = read(from, checks);
  } else if constexpr (std::is_same_v<Value, std::optional<SeriesMember>>) {
    if (Access::has(wire)) value = read(from, checks);
  } else {
    value = from;
  }
}

// Checks what single fields do not show.
void check_fields(const DatasetInfo& info, FieldChecks& checks) {
  std::uint64_t samples = 1;
  for (const std::int32_t side : info.dims) samples *= static_cast<std::uint64_t>(side);
  for (const double length : info.spacing) {
    checks.require(std::isfinite(length) && length > 0, "DatasetInfo.spacing",
                   "must be finite and greater than 0 on every axis.");
  }
  checks.require(info.min <= info.max, "DatasetInfo.max", "must be at least min.");
  checks.integer("DatasetInfo.void_samples", info.void_samples, 0, samples);
  checks.integer("DatasetInfo.margin", static_cast<std::uint64_t>(info.margin), 0,
                 kMaxGridSteps / 2);
  checks.integer("DatasetInfo.grid_exponent", static_cast<std::uint64_t>(info.grid_exponent), 1,
                 kMaxGridExponent);
  checks.at_most("DatasetInfo.suggested_isovalues", info.suggested_isovalues.size(),
                 kMaxSuggestedIsovalues, "values");
  if (checks.first()) return;
  checks.require(info.grid_exponent >= grid_exponent_for(info.dims, info.margin),
                 "DatasetInfo.grid_exponent", "is too small for the samples and the margin.");
}

}  // namespace

void write_dataset(const DatasetInfo& info, v1::DatasetInfo& wire) {
#define MULTITETRA_WRITE(key, member, help) write_field(key##_access(), info.member, wire);
  MULTITETRA_DATASET_FIELDS(MULTITETRA_WRITE)
#undef MULTITETRA_WRITE
  wire.set_content_id(info.content_id);
  if (info.member && info.member->label && info.label_extent) {
    write(*info.label_extent, *wire.mutable_member()->mutable_label());
  }
}

DatasetInfo read_dataset(const v1::DatasetInfo& wire, FieldChecks& checks) {
  DatasetInfo info;
#define MULTITETRA_READ(key, member, help) \
  read_field(key##_access(), "DatasetInfo." #key, wire, info.member, checks);
  MULTITETRA_DATASET_FIELDS(MULTITETRA_READ)
#undef MULTITETRA_READ
  info.content_id = wire.content_id();
  if (checks.first()) return info;
  check_fields(info, checks);
  if (wire.member().has_label() && !checks.first()) {
    info.label_extent = read_extent(wire.member().label(), info, checks);
  }
  return info;
}

}  // namespace multitetra::wire

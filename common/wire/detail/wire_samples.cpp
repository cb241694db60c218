#include "common/wire/detail/wire_samples.hpp"

#include <algorithm>
#include <utility>

#include "common/wire/detail/wire_vectors.hpp"

namespace multitetra::wire {
namespace {

CoordinateSystem read_coordinates(std::string_view field, v1::CoordinateSystem wire,
                                  FieldChecks& checks) {
  return checks.enumerator<CoordinateSystem>(field, wire, CoordinateSystem::kIndex,
                                             CoordinateSystem::kWorld);
}

Vec3 read_finite_vec3(std::string_view field, const Numbers& wire, FieldChecks& checks) {
  for (const double number : wire) checks.finite(field, number);
  return read_vec3(field, wire, checks);
}

ProbedPlace read(const v1::ProbedPlace& wire, FieldChecks& checks) {
  ProbedPlace place{.world = read_finite_vec3("ProbedPlace.world", wire.world(), checks),
                    .index = read_finite_vec3("ProbedPlace.index", wire.index(), checks)};
  if (wire.has_value()) {
    checks.finite("ProbedPlace.value", wire.value());
    place.value = wire.value();
    place.gradient = read_finite_vec3("ProbedPlace.gradient", wire.gradient(), checks);
  }
  return place;
}

}  // namespace

void write(const Slice& slice, v1::Slice& wire) {
  const SliceRequest& plane = slice.slice;
  wire.set_request_id(slice.request_id);
  wire.set_dataset(slice.dataset);
  wire.set_content_id(slice.content_id);
  wire.set_coordinates(to_wire<v1::CoordinateSystem>(plane.coordinates));
  write_vec3(plane.origin, *wire.mutable_origin());
  write_vec3(plane.right, *wire.mutable_right());
  write_vec3(plane.down, *wire.mutable_down());
  wire.set_width(plane.width);
  wire.set_height(plane.height);
  wire.set_interpolation(to_wire<v1::Interpolation>(plane.interpolation));
  wire.set_detail(to_wire<v1::SliceDetail>(plane.detail));
  if (plane.layers > 1) {
    write_vec3(plane.inward, *wire.mutable_inward());
    wire.set_layers(plane.layers);
  }
  wire.set_accepts_packed(plane.accepts_packed);
  if (slice.priority != Priority::kNormal) {
    wire.set_priority(to_wire<v1::Priority>(slice.priority));
  }
}

Slice read(const v1::Slice& wire, FieldChecks& checks) {
  checks.dataset_name("Slice.dataset", wire.dataset());
  Slice slice{.request_id = wire.request_id(),
              .dataset = wire.dataset(),
              .slice = {},
              .priority = checks.enumerator<Priority>("Slice.priority", wire.priority(),
                                                      Priority::kBackground, Priority::kNormal),
              .content_id = wire.content_id()};
  SliceRequest& plane = slice.slice;
  plane.coordinates = read_coordinates("Slice.coordinates", wire.coordinates(), checks);
  plane.origin = read_vec3("Slice.origin", wire.origin(), checks);
  plane.right = read_vec3("Slice.right", wire.right(), checks);
  plane.down = read_vec3("Slice.down", wire.down(), checks);
  plane.width = wire.width();
  plane.height = wire.height();
  plane.layers = std::max(1U, wire.layers());
  if (plane.layers > 1) plane.inward = read_vec3("Slice.inward", wire.inward(), checks);
  plane.accepts_packed = wire.accepts_packed();
  plane.interpolation = checks.enumerator<Interpolation>(
      "Slice.interpolation", wire.interpolation(), Interpolation::kLinear, Interpolation::kLinear);
  plane.detail = checks.enumerator<SliceDetail>("Slice.detail", wire.detail(), SliceDetail::kCoarse,
                                                SliceDetail::kAuto);
  checks.valid(validated(plane));
  return slice;
}

void write(const Probe& probe, v1::Probe& wire) {
  wire.set_request_id(probe.request_id);
  wire.set_dataset(probe.dataset);
  wire.set_content_id(probe.content_id);
  wire.set_coordinates(to_wire<v1::CoordinateSystem>(probe.probe.coordinates));
  for (const Vec3& place : probe.probe.places) {
    for (const double coordinate : place) wire.add_places(coordinate);
  }
}

Probe read(const v1::Probe& wire, FieldChecks& checks) {
  checks.dataset_name("Probe.dataset", wire.dataset());
  Probe probe{.request_id = wire.request_id(),
              .dataset = wire.dataset(),
              .probe = {},
              .content_id = wire.content_id()};
  probe.probe.coordinates = read_coordinates("Probe.coordinates", wire.coordinates(), checks);
  const auto numbers = static_cast<std::size_t>(wire.places_size());
  checks.require(numbers % 3 == 0, "Probe.places", "must have three numbers for each place.");
  checks.at_most("Probe.places", numbers / 3, kMaxProbedPlaces, "places");
  if (checks.first()) return probe;
  for (int i = 0; i + 2 < wire.places_size(); i += 3) {
    probe.probe.places.push_back({wire.places(i), wire.places(i + 1), wire.places(i + 2)});
  }
  checks.valid(validated(probe.probe));
  return probe;
}

void write(const SliceReply& reply, v1::SliceReply& wire) {
  wire.set_request_id(reply.request_id);
  wire.set_width(reply.width);
  wire.set_height(reply.height);
  wire.set_sample_spacing(reply.sample_spacing);
  wire.set_values(*reply.values);
  if (reply.layers > 1) wire.set_layers(reply.layers);
  if (reply.packed_type) wire.set_packed_type(to_wire<v1::SampleType>(*reply.packed_type));
}

SliceReply read(v1::SliceReply& wire, FieldChecks& checks) {
  checks.integer("SliceReply.width", wire.width(), 1, kMaxSlicePixels);
  checks.integer("SliceReply.height", wire.height(), 1, kMaxSlicePixels);
  checks.integer("SliceReply.sample_spacing", wire.sample_spacing(), 1, 1 << 19);
  checks.integer("SliceReply.layers", wire.layers(), 0, kMaxSlicePixels);
  const std::uint32_t layers = std::max(1U, wire.layers());
  const std::uint64_t pixels = std::uint64_t{wire.width()} * wire.height();
  std::optional<SampleType> packed_type;
  if (wire.packed_type() != v1::SAMPLE_TYPE_UNSPECIFIED) {
    packed_type = checks.enumerator<SampleType>("SliceReply.packed_type", wire.packed_type(),
                                                SampleType::kF32, {});
  } else {
    checks.require(wire.values().size() == sizeof(float) * pixels * layers, "SliceReply.values",
                   "must have 4 bytes for each pixel.");
  }
  return {.request_id = wire.request_id(),
          .width = wire.width(),
          .height = wire.height(),
          .layers = layers,
          .sample_spacing = wire.sample_spacing(),
          .values = std::make_shared<const std::string>(std::move(*wire.mutable_values())),
          .packed_type = packed_type};
}

void write(const ProbeReply& reply, v1::ProbeReply& wire) {
  wire.set_request_id(reply.request_id);
  for (const ProbedPlace& place : reply.places) {
    v1::ProbedPlace& into = *wire.add_places();
    write_vec3(place.world, *into.mutable_world());
    write_vec3(place.index, *into.mutable_index());
    if (!place.value) continue;
    into.set_value(*place.value);
    write_vec3(place.gradient.value_or(Vec3{0, 0, 0}), *into.mutable_gradient());
  }
}

ProbeReply read(const v1::ProbeReply& wire, FieldChecks& checks) {
  checks.at_most("ProbeReply.places", static_cast<std::size_t>(wire.places_size()),
                 kMaxProbedPlaces, "places");
  ProbeReply reply{.request_id = wire.request_id(), .places = {}};
  if (checks.first()) return reply;
  for (const v1::ProbedPlace& place : wire.places()) reply.places.push_back(read(place, checks));
  return reply;
}

}  // namespace multitetra::wire

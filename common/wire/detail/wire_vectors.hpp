// Converts vectors to and from repeated numbers.
#pragma once

#include <algorithm>
#include <string_view>

#include <google/protobuf/repeated_field.h>

#include "common/base/vec3.hpp"
#include "common/wire/detail/wire_checks.hpp"

namespace multitetra::wire {

using Numbers = google::protobuf::RepeatedField<double>;

inline void write_vec3(const Vec3& place, Numbers& wire) {
  wire.Assign(place.begin(), place.end());
}

[[nodiscard]] inline Vec3 read_vec3(std::string_view field, const Numbers& wire,
                                    FieldChecks& checks) {
  checks.exactly(field, wire.size(), 3);
  Vec3 place = {};
  std::copy_n(wire.begin(), std::min(wire.size(), 3), place.begin());
  return place;
}

}  // namespace multitetra::wire

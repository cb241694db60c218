// Numbers formatted for people.
#pragma once

#include <cstdint>
#include <string>

#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

[[nodiscard]] std::string human_bytes(std::uint64_t bytes);  // "12.3 MiB".
[[nodiscard]] std::string human_count(std::uint64_t count);  // "1 234 567".
// "1 tile", "2 345 tiles"; for nouns whose plural adds an s.
[[nodiscard]] std::string human_count_of(std::uint64_t count, const std::string& noun);
// "0.45", "3.2", "1 234": two digits below 10.
[[nodiscard]] std::string human_speed(double per_second);
[[nodiscard]] std::string human_seconds(double seconds);  // "24 ms", "1.25 s", "3 min 05 s"
// Up to 6 digits: "500.5". For lengths and measures; values and places have those below.
[[nodiscard]] std::string human_number(double value);

// A value of the data, to a hundred-thousandth of their range: "1737400.05".
[[nodiscard]] std::string human_value(double value, const DatasetInfo& info);
// World coordinates, to a hundredth of a voxel: "500012.25 5400031.5 120".
[[nodiscard]] std::string human_place(const Vec3& place, double voxel_length);

// "0.24 mm"; without a unit "0.24 units".
[[nodiscard]] std::string human_length(double length, const std::string& unit);
// Formats a length in world units in the request's unit and in world units: "0.5 voxels (0.24 mm)",
// or "0.24 mm".
[[nodiscard]] std::string human_error(double world, ErrorUnit unit, const DatasetInfo& info);

// "-300.5 (skin), 300.5 (bone)", with what is known about them; "none".
[[nodiscard]] std::string human_suggestions(const DatasetInfo& info);

// "heart", field p, time 0.25 s, label 3 (liver, #dd8265); omits unknown parts.
[[nodiscard]] std::string human_member(const SeriesMember& member);

}  // namespace multitetra

// Setters for tables of request fields as users write them (surface_query.hpp).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace multitetra {

// The reason why a value is invalid, such as "must be voxel or world"; nullopt if it is valid.
using FieldError = std::optional<std::string>;

// Returns a member of a query, or of the part of it that has this member.
template <auto Member, typename Query>
[[nodiscard]] auto& member_of(Query& query) {
  if constexpr (requires { query.request.*Member; }) {
    return query.request.*Member;
  } else if constexpr (requires { query.request.thresholds.*Member; }) {
    return query.request.thresholds.*Member;
  } else if constexpr (requires { query.colors.*Member; }) {
    return query.colors.*Member;
  } else if constexpr (requires { query.slice.*Member; }) {
    return query.slice.*Member;
  } else if constexpr (requires { query.slice.pixels.*Member; }) {
    return query.slice.pixels.*Member;
  } else {
    return query.*Member;
  }
}

// Converts "voxel|world" to "voxel or world".
[[nodiscard]] std::string alternatives(std::string_view syntax);

// Sets a member to Read(text), which is nullopt for texts other than the field's value_syntax.
template <auto Member, auto Read, typename Field, typename Query>
FieldError set_word(const Field& field, std::string_view text, Query& query) {
  const auto value = Read(text);
  if (!value) return "must be " + alternatives(field.value_syntax);
  member_of<Member>(query) = *value;
  return std::nullopt;
}

}  // namespace multitetra

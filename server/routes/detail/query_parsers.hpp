// Parses a query's parameters into the members of a struct. Pure.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/parse_number.hpp"
#include "common/base/result.hpp"
#include "common/request/surface_query.hpp"

namespace multitetra {

template <typename Query>
struct Setter {
  std::function<FieldError(std::string_view value, Query& query)> set;
  bool is_repeatable = false;
};
template <typename Query>
using Setters = std::map<std::string_view, Setter<Query>>;

// Sets the number, optional or not, that `member` of the query returns.
template <typename Query, typename Member>
[[nodiscard]] Setter<Query> number(Member member) {
  return {[member](std::string_view text, Query& query) -> FieldError {
    auto& place = member(query);
    using Place = std::remove_reference_t<decltype(place)>;
    if constexpr (requires { place.has_value(); }) {
      place = parse_number<typename Place::value_type>(text);
      if (!place) return "is no number that fits here";
    } else {
      const auto value = parse_number<Place>(text);
      if (!value) return "is no number that fits here";
      place = *value;
    }
    return std::nullopt;
  }};
}

// Sets an enumeration from one of a few words. `read` returns nullopt for others.
template <typename Query, typename Member, typename Read>
[[nodiscard]] Setter<Query> word(Member member, Read read, std::string words) {
  return {[=](std::string_view text, Query& query) -> FieldError {
    const auto value = read(text);
    if (!value) return "must be " + words;
    member(query) = *value;
    return std::nullopt;
  }};
}

// Returns kInvalidArgument, naming the parameter, if one is unknown, invalid, or repeated without
// being repeatable.
template <typename Query>
[[nodiscard]] Result<Query> parse_query(
    const std::vector<std::pair<std::string, std::string>>& query, const Setters<Query>& setters) {
  const auto refuse = [](const std::string& text) {
    return fail(ErrorCode::kInvalidArgument, text);
  };
  Query parsed;
  std::set<std::string_view> given;
  for (const auto& [name, value] : query) {
    const auto setter = setters.find(name);
    if (setter == setters.end()) {
      std::string known;
      for (const auto& [one, unused] : setters) known.append(known.empty() ? "" : ", ") += one;
      return refuse("There is no parameter \"" + name + "\"; those that are: " + known + ".");
    }
    if (!given.insert(setter->first).second && !setter->second.is_repeatable) {
      return refuse("The parameter " + name + " is given twice.");
    }
    if (const FieldError objection = setter->second.set(value, parsed)) {
      return refuse("The parameter " + name + "=" + value + ": " + *objection + ".");
    }
  }
  return parsed;
}

}  // namespace multitetra

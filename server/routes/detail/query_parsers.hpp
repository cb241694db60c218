// Parses a query's parameters into the members of a struct. Pure.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/surface_query.hpp"

namespace multitetra {

// A parameter of a query; compare RequestField. The description of the interface is made from these
// tables too.
template <typename Query>
struct QueryField {
  std::string_view name;
  std::string_view value_syntax;  // "x|y|z" or a description.
  std::string_view default_text;  // Empty: none.
  std::string_view help;          // One sentence, without the default.
  FieldError (*set)(const QueryField& field, std::string_view text, Query& query);
  bool is_repeatable = false;
  bool is_required = false;
};

template <typename Query>
struct Setter {
  std::function<FieldError(std::string_view value, Query& query)> set;
  bool is_repeatable = false;
};
template <typename Query>
using Setters = std::map<std::string_view, Setter<Query>>;

// Returns the setters of a table of fields. part(query) is what they set.
template <typename Query, typename Fields, typename Part>
[[nodiscard]] Setters<Query> setters_of(const Fields& fields, const Part& part) {
  Setters<Query> setters;
  for (const auto& field : fields) {
    setters[field.name] = {
        .set = [&field, part](std::string_view text,
                              Query& query) { return field.set(field, text, part(query)); },
        .is_repeatable = field.is_repeatable};
  }
  return setters;
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
      return refuse("Unknown parameter \"" + name + "\"; valid parameters: " + known + ".");
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

// Parses a query whose table of fields sets it.
template <typename Query>
[[nodiscard]] Result<Query> parse_query(
    const std::vector<std::pair<std::string, std::string>>& query,
    std::span<const QueryField<Query>> fields) {
  return parse_query<Query>(
      query, setters_of<Query>(fields, [](Query& whole) -> Query& { return whole; }));
}

}  // namespace multitetra

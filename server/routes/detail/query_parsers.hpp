// A query's parameters as the members of a struct: each is said once, understood, or refused by its
// name. Pure.
#pragma once

#include <charconv>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

// What is wrong with a value, nullopt if nothing is.
using Objection = std::optional<std::string>;
template <typename Query>
using Setter = std::function<Objection(std::string_view value, Query& query)>;
template <typename Query>
using Setters = std::map<std::string_view, Setter<Query>>;

template <typename Number>
[[nodiscard]] std::optional<Number> number_from(std::string_view text) {
  Number value{};
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// "1.5,-2,3e4", `least` to `most` of them; nullopt for anything else.
[[nodiscard]] inline std::optional<std::vector<double>> numbers_from(std::string_view text,
                                                                     std::size_t least,
                                                                     std::size_t most) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const auto number = number_from<double>(text.substr(at, comma - at));
    if (!number || numbers.size() == most) return std::nullopt;
    numbers.push_back(*number);
    at = comma + 1;
  }
  if (numbers.size() < least) return std::nullopt;
  return numbers;
}

// Sets what `member` of the query refers to, a number or an optional one.
template <typename Query, typename Member>
[[nodiscard]] Setter<Query> number(Member member) {
  return [member](std::string_view text, Query& query) -> Objection {
    auto& place = member(query);
    using Place = std::remove_reference_t<decltype(place)>;
    if constexpr (requires { place.has_value(); }) {
      place = number_from<typename Place::value_type>(text);
      if (!place) return "is no number that fits here";
    } else {
      const auto value = number_from<Place>(text);
      if (!value) return "is no number that fits here";
      place = *value;
    }
    return std::nullopt;
  };
}

// The same for a value that is one of a few words; `read` gives nullopt for others.
template <typename Query, typename Member, typename Read>
[[nodiscard]] Setter<Query> word(Member member, Read read, std::string words) {
  return [=](std::string_view text, Query& query) -> Objection {
    const auto value = read(text);
    if (!value) return "must be " + words;
    member(query) = *value;
    return std::nullopt;
  };
}

// kInvalidArgument, naming the parameter, when one is unknown, not understood, or said twice
// without being `repeatable`.
template <typename Query>
[[nodiscard]] Result<Query> parse_query(
    const std::vector<std::pair<std::string, std::string>>& query, const Setters<Query>& setters,
    std::string_view repeatable = {}) {
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
    if (!given.insert(setter->first).second && name != repeatable) {
      return refuse("The parameter " + name + " is there twice.");
    }
    if (const Objection objection = setter->second(value, parsed)) {
      return refuse("The parameter " + name + "=" + value + ": " + *objection + ".");
    }
  }
  return parsed;
}

}  // namespace multitetra

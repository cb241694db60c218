#include "common/wire/mesh_readers.hpp"

#include <algorithm>

#include "common/base/parse_number.hpp"
#include "common/wire/detail/mesh_bytes.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kSpaces = " \t\r\n\v\f";

template <typename Number>
Number number_from(std::string_view word, const char* kind) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto number = parse_number<Number>(word);
  if (!number)
    throw MeshFileError("'" + std::string(word.substr(0, 40)) + "' is not a valid " + kind);
  return *number;
}

}  // namespace

std::string_view MeshBytes::take_word() {
  rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpaces), rest_.size()));
  const std::string_view word = rest_.substr(0, rest_.find_first_of(kSpaces));
  rest_.remove_prefix(word.size());
  return word;
}

std::string_view MeshBytes::take_text_line() {
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  const std::string_view line = rest_.substr(0, end);
  rest_.remove_prefix(end);
  rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest_.size()));
  return line;
}

double MeshBytes::take_decimal() {
  const std::string_view word = take_word();
  if (word.empty()) throw MeshFileError("it ends too early", kGetCompleteCopy);
  return decimal_from(word);
}

double decimal_from(std::string_view word) { return number_from<double>(word, "number"); }
std::int64_t integer_from(std::string_view word) {
  return number_from<std::int64_t>(word, "integer");
}

}  // namespace multitetra

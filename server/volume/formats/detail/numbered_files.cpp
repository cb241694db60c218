#include "server/volume/formats/detail/numbered_files.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <system_error>

#include "common/base/parse_number.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::int64_t kMaxFiles = 1 << 16;
constexpr std::size_t kMaxWidth = 10;
constexpr std::string_view kDigits = "0123456789";

// Parses an integer small enough to add two of them.
std::optional<std::int64_t> small_integer(std::string_view text) {
  const std::optional<std::int64_t> value = integer(text);
  constexpr std::int64_t kLimit = std::int64_t{1} << 30;
  return value && *value > -kLimit && *value < kLimit ? value : std::nullopt;
}

// Parses the pattern; returns nullopt unless it has exactly one '%', in a conversion.
std::optional<NumberedFiles> pattern_of(const std::string& pattern) {
  const std::size_t begin = pattern.find('%');
  if (begin == std::string::npos) return std::nullopt;
  const std::size_t end = pattern.find_first_not_of(kDigits, begin + 1);
  if (end == std::string::npos || pattern[end] != 'd') return std::nullopt;
  if (pattern.find('%', end) != std::string::npos) return std::nullopt;
  const std::string width = pattern.substr(begin + 1, end - begin - 1);
  NumberedFiles files;
  files.before = pattern.substr(0, begin);
  files.after = pattern.substr(end + 1);
  files.zeros = width.starts_with('0');
  if (!width.empty()) {
    const std::optional<std::int64_t> number = small_integer(width);
    if (!number || *number > static_cast<std::int64_t>(kMaxWidth)) return std::nullopt;
    files.width = static_cast<std::size_t>(*number);
  }
  return files;
}

}  // namespace

std::string NumberedFiles::name(std::int64_t index) const {
  std::string digits = std::to_string(number(index));
  if (digits.size() < width) digits.insert(0, width - digits.size(), zeros ? '0' : ' ');
  return before + digits + after;
}

bool is_numbered(std::string_view value) {
  std::size_t at = value.find('%');
  while (at != std::string_view::npos && value.substr(at).starts_with("%%")) {
    at = value.find('%', at + 2);
  }
  if (at == std::string_view::npos) return false;
  const std::size_t end = value.find_first_not_of(kDigits, at + 1);
  return end != std::string_view::npos && value[end] == 'd';
}

std::optional<NumberedFiles> numbered_files(const std::string& value) {
  const std::vector<std::string> words = words_of(value);
  if (words.size() != 4 && words.size() != 5) return std::nullopt;
  std::optional<NumberedFiles> files = pattern_of(words[0]);
  const std::optional<std::int64_t> first = small_integer(words[1]);
  const std::optional<std::int64_t> last = small_integer(words[2]);
  const std::optional<std::int64_t> step = small_integer(words[3]);
  if (!files || !first || !last || !step || *step == 0) return std::nullopt;
  if (*first != *last && (*first < *last) != (*step > 0)) return std::nullopt;
  files->first = *first;
  files->step = *step;
  files->count = (*last - *first) / *step + 1;
  return files->count <= kMaxFiles ? files : std::nullopt;
}

std::vector<std::string> numbered_names(const std::filesystem::path& header,
                                        const std::string& value) {
  const std::optional<NumberedFiles> files = numbered_files(value);
  if (!files || files->number(0) < 0 || files->number(files->count - 1) < 0) {
    fail_reading(header, "the pattern of its data files is invalid: '" + value + "'",
                 "Write a pattern with one number such as %d or %03d, followed by the first "
                 "number, the last and the step");
  }
  std::vector<std::string> names;
  for (std::int64_t i = 0; i < files->count; ++i) names.push_back(files->name(i));
  return names;
}

}  // namespace multitetra

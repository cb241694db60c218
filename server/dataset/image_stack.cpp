#include "server/dataset/image_stack.hpp"
#include "common/base/text.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <string>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::size_t digits_at(std::string_view text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size() && is_digit(text[end])) ++end;
  return end - at;
}

// A printf conversion of an integer at the start of `text`: '%', digits, 'd'.
struct Conversion {
  std::size_t length = 0;     // Of the conversion's text; 0 when there is none.
  std::size_t min_width = 1;  // Digits that it prints at least.
};

Conversion conversion_at(std::string_view text) {
  if (text.empty() || text[0] != '%') return {};
  const std::size_t digits = digits_at(text, 1);
  if (digits > 2 || 1 + digits >= text.size() || text[1 + digits] != 'd') return {};
  const std::string width(text.substr(1, digits));
  return {.length = digits + 2, .min_width = width.empty() ? 1 : std::stoul(width)};
}

// Whether all of `name` matches all of `pattern`: '*' any characters, '?' any one, a conversion a
// run of digits, any other character itself.
bool matches(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == '*') {
    for (std::size_t skipped = 0; skipped <= name.size(); ++skipped) {
      if (matches(pattern.substr(1), name.substr(skipped))) return true;
    }
    return false;
  }
  if (const Conversion conversion = conversion_at(pattern); conversion.length > 0) {
    const std::size_t digits = digits_at(name, 0);
    return digits >= conversion.min_width && digits > 0 &&
           matches(pattern.substr(conversion.length), name.substr(digits));
  }
  return !name.empty() && (pattern[0] == '?' || pattern[0] == name[0]) &&
         matches(pattern.substr(1), name.substr(1));
}

bool has_tiff_suffix(const fs::path& file) {
  const std::string suffix = lower_case(file.extension().string());
  return suffix == ".tif" || suffix == ".tiff";
}

}  // namespace

bool is_stack_pattern(std::string_view file_name) {
  for (std::size_t at = 0; at < file_name.size(); ++at) {
    if (file_name[at] == '*' || file_name[at] == '?') return true;
    if (conversion_at(file_name.substr(at)).length > 0) return true;
  }
  return false;
}

bool naturally_less(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      while (i < a.size() && a[i] == '0') ++i;
      while (j < b.size() && b[j] == '0') ++j;
      const std::string_view x = a.substr(i, digits_at(a, i));
      const std::string_view y = b.substr(j, digits_at(b, j));
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      i += x.size();
      j += y.size();
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // They differ in leading zeros at most.
}

std::vector<fs::path> stack_files(const fs::path& path) {
  std::error_code error;
  const bool is_directory = fs::is_directory(path, error);
  const std::string pattern = is_directory ? "*" : path.filename().string();
  fs::path directory = is_directory ? path : path.parent_path();
  if (directory.empty()) directory = ".";

  std::vector<fs::path> files;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file_name = entry->path().filename().string();
    if (file_name.starts_with('.') || !has_tiff_suffix(entry->path())) continue;
    if (matches(pattern, file_name)) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return naturally_less(a.filename().string(), b.filename().string());
  });
  return files;
}

}  // namespace multitetra

#include "server/operations/secrets.hpp"

#include <algorithm>

#include "common/base/hex_text.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kMask = "***";
constexpr std::string_view kEnds = "/?&=;, \t\r\n\"'\\";

// Decodes %XX once; keeps what is not encoded correctly.
std::string decoded(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto high =
        text[i] == '%' && i + 2 < text.size() ? value_of_hex_digit(text[i + 1]) : std::nullopt;
    const auto low = high ? value_of_hex_digit(text[i + 2]) : std::nullopt;
    plain += low ? static_cast<char>(*high << 4 | *low) : text[i];
    if (low) i += 2;
  }
  return plain;
}

bool names_a_secret(std::string_view word) {
  constexpr std::string_view kWords[] = {"token", "key", "secret", "password", "auth"};
  return std::any_of(std::begin(kWords), std::end(kWords),
                     [&](std::string_view name) { return word.find(name) != word.npos; });
}

// Returns whether the word is one of our tokens, or follows the name of a secret.
bool is_secret(std::string_view word, std::string_view before, char separator) {
  if (lower_case(word).find("mt_") != std::string::npos) return true;
  const std::string name = lower_case(before);
  return !word.empty() && word != "..." && word != kMask &&
         (separator == '=' ? names_a_secret(name) : separator == '/' && name == "token");
}

std::string masked(std::string_view text) {
  std::string kept;
  std::string before;
  char separator = 0;
  while (true) {
    // The value of a parameter may contain separators of paths.
    const bool is_value = separator == '=' && names_a_secret(lower_case(before));
    const std::size_t end = text.find_first_of(is_value ? std::string_view("&; \"") : kEnds);
    const std::string_view word = text.substr(0, end);
    kept += is_secret(word, before, separator) ? kMask : word;
    if (end == std::string_view::npos) return kept;
    before = word;
    separator = text[end];
    kept += separator;
    text.remove_prefix(end + 1);
    // Repeated slashes separate the same two words.
    while (separator == '/' && text.starts_with('/')) {
      kept += '/';
      text.remove_prefix(1);
    }
  }
}

}  // namespace

std::string without_secrets(std::string_view text) {
  bool has_secrets = false;
  std::string plain(text);
  for (int times = 0; times < 4; ++times) {  // A text may be encoded repeatedly.
    std::string clean = masked(plain);
    has_secrets = has_secrets || clean != plain;
    plain = decoded(clean);
    if (plain == clean) break;
  }
  return has_secrets ? plain : std::string(text);
}

}  // namespace multitetra

// Addresses in texts for people.
#pragma once

#include <string>
#include <string_view>

namespace multitetra {

// Returns `text` with the user and password of every address in it
// ("https://user:password@host/path") replaced by ***.
[[nodiscard]] inline std::string without_password(std::string_view text) {
  std::string shown;
  for (std::size_t scheme = text.find("://"); scheme != std::string_view::npos;
       scheme = text.find("://")) {
    shown += text.substr(0, scheme + 3);
    text.remove_prefix(scheme + 3);
    const std::string_view authority = text.substr(0, text.find_first_of("/?# \t\n'\""));
    const std::size_t at = authority.rfind('@');
    if (at == std::string_view::npos) continue;
    shown += "***";
    text.remove_prefix(at);
  }
  return shown + std::string(text);
}

}  // namespace multitetra

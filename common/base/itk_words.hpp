// What ITK says of its trouble, for a sentence of ours. No ITK is seen from here.
#pragma once

#include <algorithm>
#include <string>
#include <utility>

namespace multitetra {

// From the description of an itk::ExceptionObject: on one line, without the name and the address of
// ITK's own object in front and without a full stop.
[[nodiscard]] inline std::string itk_words(std::string description) {
  std::string text = std::move(description);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  if (const std::size_t address = text.find("): "); address != std::string::npos) {
    text.erase(0, address + 3);
  }
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text.empty() ? "the reader of this format gives up without a reason" : text;
}

}  // namespace multitetra

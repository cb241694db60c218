// The fields and keys of a NRRD file's header (http://teem.sourceforge.net/nrrd/format.html),
// without their interpretation.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

struct NrrdHeader {
  std::string text;  // Up to the empty line that ends the header.
  std::map<std::string, std::string, std::less<>> fields;  // "name: value"; names in lower case.
  std::map<std::string, std::string, std::less<>> keys;    // "name:=value"
  std::vector<std::string> listed_files;                   // The lines after "data file: LIST".
  // Includes the empty line: the offset of attached samples.
  std::size_t bytes = 0;
  // Whether there is an empty line; only detached headers may lack it.
  bool has_end = false;

  // Returns the field's value; empty if it is absent.
  [[nodiscard]] std::string field(std::string_view name) const;
  [[nodiscard]] std::string key(std::string_view name) const;
  // Returns one word of the field per axis: a number, a name, a vector in parentheses, a quoted
  // text. Returns nothing if the number of words differs from `axes`.
  [[nodiscard]] std::vector<std::string> axis_words(std::string_view name, std::size_t axes) const;
};

inline constexpr std::size_t kMaxNrrdHeaderBytes = std::size_t{1} << 22;

// Parses the header at the start of a file. Lines end in LF, CR LF or CR; of repeated fields the
// last one counts. Never fails.
[[nodiscard]] NrrdHeader parse_nrrd_header(std::string_view text);

}  // namespace multitetra

// The header of a NRRD file as fields and keys (http://teem.sourceforge.net/nrrd/format.html).
// Their meaning is up to the reader.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

struct NrrdHeader {
  std::string text;                                        // Up to the empty line at its end.
  std::map<std::string, std::string, std::less<>> fields;  // "name: value"; names in lower case.
  std::map<std::string, std::string, std::less<>> keys;    // "name:=value"
  std::vector<std::string> listed_files;                   // The lines after "data file: LIST".
  std::size_t bytes = 0;  // With the empty line: where attached samples begin.
  bool has_end = false;   // Whether there is an empty line. Only a detached header may lack it.

  // The value of the field; empty without it.
  [[nodiscard]] std::string field(std::string_view name) const;
  [[nodiscard]] std::string key(std::string_view name) const;
  // A word of the field for each axis: a number, a name, a vector in brackets, a text in quotes;
  // none when the field has not as many words as there are axes.
  [[nodiscard]] std::vector<std::string> axis_words(std::string_view name, std::size_t axes) const;
};

inline constexpr std::size_t kMostNrrdHeaderBytes = std::size_t{1} << 22;

// `text` is the beginning of a file. Lines end in LF, CR LF or CR; of a field that comes twice the
// last line counts. Nothing is refused.
[[nodiscard]] NrrdHeader parse_nrrd_header(std::string_view text);

}  // namespace multitetra

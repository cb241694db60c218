// The header of a NRRD as its lines, to be looked at and changed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

class NrrdLines {
 public:
  // Of a header up to its first empty line.
  explicit NrrdLines(std::string_view header);

  [[nodiscard]] std::vector<std::string>& lines() { return lines_; }
  [[nodiscard]] const std::vector<std::string>& lines() const { return lines_; }
  // Where the line "field: value" is; -1: nowhere.
  [[nodiscard]] std::ptrdiff_t position(std::string_view field) const;
  // The field's value; nullopt without it.
  [[nodiscard]] std::optional<std::string> value(std::string_view field) const;
  // The value of the key ("key:=value").
  [[nodiscard]] std::optional<std::string> key(std::string_view name) const;
  // Replaces the field's line, or adds one.
  void set(std::string_view field, const std::string& value);
  void remove(std::string_view field);

  // Makes names of data files absolute, as they are seen from `file`, whose header this is; an
  // attached header becomes a detached one that skips itself.
  void detach(const std::filesystem::path& file);

  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::string> lines_;
};

}  // namespace multitetra

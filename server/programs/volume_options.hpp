// Options that choose a volume of a source and describe raw samples.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/command.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {

// Throws ExitError (kUsage) when `text` names no component.
[[nodiscard]] ComponentChoice component_from(const std::string& text);

// The value of --outside: none for "void". Throws std::invalid_argument unless it is that or a
// finite number.
[[nodiscard]] std::optional<double> outside_from(const std::string& text);

// --outside (an empty text where it is not given) and --margin, of commands that prepare.
void add_border_options(Command& command, std::string& outside, std::optional<int>& margin);

struct VolumeOptions {
  std::string array;
  std::optional<int> level;
  std::optional<int> time;
  std::optional<int> channel;
  std::string series;
  std::string component;
  bool follow = false;
  bool resample = false;
  std::vector<std::int32_t> dims;
  std::string type = "u8";
  std::string endian = "little";
  std::uint64_t header_bytes = 0;
  std::vector<double> spacing;
  std::vector<double> origin;
  std::string orient;  // As axis_directions_from() reads it.
  std::string space;   // LPS, RAS or none; empty: as the file says.
  std::string length_unit;

  // Adds --array, --level, --time, --channel, --series, --component, --follow, --resample, the
  // layout of raw samples, and the places of samples.
  void add_to(Command& command);
  // Adds --space, for commands whose own coordinates have no option of that name.
  void add_space_to(Command& command);
  // The parsed options. Throws ExitError (kUsage) when a component is none, a spacing is not
  // positive, or the length unit is no unit.
  [[nodiscard]] VolumeFileOptions parsed() const;
  // Those that are not their defaults, as they would be written; empty: none.
  [[nodiscard]] std::string command_line() const;

 private:
  [[nodiscard]] Placement placement() const;
};

}  // namespace multitetra

// Options that choose a volume from a source and describe raw samples.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/command.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {

// Throws ExitError (kUsage) unless `text` names a component.
[[nodiscard]] ComponentChoice component_from(const std::string& text);

// Parses --pad-value: none for "void". Throws std::invalid_argument unless it is that or a finite
// number.
[[nodiscard]] std::optional<double> outside_from(const std::string& text);

// Adds --pad-value (empty by default) and --pad, for commands that prepare.
void add_border_options(Command& command, std::string& outside, std::optional<int>& margin);

// Adds --require-isolation.
void add_isolation_option(Command& command, bool& is_required);
// Applies it. Prints what the kernel lacks for isolating readers, once.
void apply_isolation_option(bool is_required);

struct VolumeOptions {
  std::string array;
  std::optional<int> level;
  std::optional<int> time;
  std::optional<int> channel;
  std::string series;
  std::string component;
  bool allow_external_files = false;
  bool resample = false;
  std::vector<std::int32_t> dims;
  std::string type = "u8";
  std::string endian = "little";
  std::uint64_t header_bytes = 0;
  std::vector<double> spacing;
  std::vector<double> origin;
  std::string orient;   // Parsed by axis_directions_from().
  bool mirror = false;  // Accepts an `orient` that mirrors.
  std::string space;    // LPS, RAS or none; empty: from the file.
  std::string length_unit;
  double subtract = 0;
  bool allow_loss = false;
  bool requires_isolation = false;

  // Adds --array, --level, --time, --channel, --series, --component, --follow, --resample,
  // --subtract, --allow-loss, --require-isolation, and options for the layout of raw samples and
  // the placement of samples.
  void add_to(Command& command);
  // Adds --space, for commands without another option of that name.
  void add_space_to(Command& command);
  // Returns the parsed options, after apply_isolation_option(). Throws ExitError (kUsage) for an
  // invalid component or length unit, or a spacing that is not positive.
  [[nodiscard]] VolumeFileOptions parsed() const;
  // Returns the options that differ from their defaults, as on the command line.
  [[nodiscard]] std::string command_line() const;

 private:
  [[nodiscard]] Placement placement() const;
};

}  // namespace multitetra

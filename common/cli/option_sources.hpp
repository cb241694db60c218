// Options of a command from three sources: flags override the environment, which overrides a file.
//
//   multitetra-server serve --config server.toml --threads 4
//   MULTITETRA_THREADS=4 multitetra-server serve --config server.toml
//
//   # server.toml: each option by its long name, without the dashes
//   datasets = ["/srv/volumes"]
//   threads = 2
//   allow-origin = ["https://example.org"]
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/cli/command.hpp"

namespace multitetra {

struct OptionSources {
  std::string config_file = {};
  bool print_config = false;
};

// Adds --config and --print-config, which can only be set as flags, and an environment variable for
// every option the command has so far: MULTITETRA_MAX_REGIONS for --max-regions.
void add_option_sources(Command& command, OptionSources& sources);

// Sets the options that neither a flag nor the environment has set from the file. Call it after
// parsing and before reading options. Throws UsageError with the file and the option if the file is
// unreadable, or contains an unknown, repeated or invalid option.
void read_config_file(const Command& command, const std::filesystem::path& file);

// Returns all options with their current values in the file's form, each with its description as a
// comment; options without a value are comments, too. The values of `path_options` (long names
// without dashes) are made absolute, so that the file means the same in every folder; URLs such as
// https://host/a.mtd are kept.
[[nodiscard]] std::string config_text(const Command& command,
                                      const std::vector<std::string>& path_options = {});

}  // namespace multitetra

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

// Adds --config and --print-config, and a name in the environment to every option that the command
// has by now: --max-regions is MULTITETRA_MAX_REGIONS. Those two alone are flags only.
void add_option_sources(Command& command, OptionSources& sources);

// Sets from the file the options that neither a flag nor the environment has set. Call it after
// parsing, before the options are read. Throws UsageError, which names the file and the option: the
// file cannot be read, names an option that there is not, or twice, or a value is no good.
void read_config_file(const Command& command, const std::filesystem::path& file);

// All options as they are now, in the file's form, each with its description as a comment. The
// values of `path_options`, by their long names without dashes, are absolute, so that the file
// means the same in every folder; addresses, as https://host/a.mtd, stay.
[[nodiscard]] std::string config_text(const Command& command,
                                      const std::vector<std::string>& path_options = {});

}  // namespace multitetra

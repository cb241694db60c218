#include "common/cli/command_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <numeric>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/base/exit_codes.hpp"
#include "common/cli/detail/help_format.hpp"
#include "common/cli/terminal.hpp"

namespace multitetra {
namespace {

// The edit distance: letters to replace, insert or delete between two words.
std::size_t edits(const std::string& from, const std::string& to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (from[i] == to[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[to.size()];
}

// The subcommand that was chosen, or the program itself.
const CLI::App& chosen(const CLI::App& app) {
  const auto subcommands = app.get_subcommands();
  return subcommands.empty() ? app : *subcommands.front();
}

// The first unexpected word; empty if there is none.
std::string unknown_word(const CLI::App& app) {
  const auto words = app.remaining(/*recurse=*/true);
  return words.empty() ? "" : words.front().substr(0, words.front().find('='));
}

// The option or subcommand nearest to an unknown word; empty when none is near.
std::string nearest_word(const CLI::App& app, const std::string& word) {
  std::vector<std::string> known;
  if (word.starts_with("-")) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    }
  } else {
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
      known.push_back(command->get_name());
    }
  }
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 4) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance =
        candidate.starts_with(word) && word.size() > 3 ? 1 : edits(word, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

int report_usage_error(const CLI::App& app, std::string text) {
  const CLI::App& command = chosen(app);
  const std::string unknown = unknown_word(app);
  const std::string meant = unknown.empty() ? "" : nearest_word(command, unknown);
  const std::string help =
      app.get_name() + (&command == &app ? "" : " " + command.get_name()) + " --help";
  if (!unknown.empty()) text = "\"" + unknown + "\" is not known here";
  while (text.ends_with('.') || text.ends_with('\n')) text.pop_back();
  std::cerr << styled(Style::kRed, app.get_name() + ":", STDERR_FILENO) << " " << text << ". "
            << (meant.empty() ? "" : "Did you mean " + meant + "? ") << "Try: " << help << "\n";
  return kUsage;
}

}  // namespace

void add_program_flags(Command& program) {
  CLI::App& app = program.app();
  app.formatter(help_formatter());
  app.set_version_flag("--version", app.get_name() + " " MULTITETRA_VERSION,
                       "Print the version and end");
  app.set_help_all_flag("--help-all", "Print the help of all commands and end")
      ->configurable(false);
}

std::optional<int> parse_command_line(Command& program, int argc, char** argv) {
  CLI::App& app = program.app();
  if (argc <= 1 && app.get_require_subcommand_min() > 0) {
    std::cerr << app.help();
    return kUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return report_usage_error(app, error.what());
  } catch (const UsageError& error) {
    return report_usage_error(app, error.what());
  }
  return std::nullopt;
}

}  // namespace multitetra

#include "common/cli/command_line.hpp"

#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/base/exit_codes.hpp"
#include "common/base/nearest_word.hpp"
#include "common/cli/detail/help_format.hpp"
#include "common/cli/terminal.hpp"

namespace multitetra {
namespace {

// Returns the chosen subcommand, or the program itself.
const CLI::App& chosen(const CLI::App& app) {
  const auto subcommands = app.get_subcommands();
  return subcommands.empty() ? app : *subcommands.front();
}

// Returns the first unexpected word; empty if there is none.
std::string unknown_word(const CLI::App& app) {
  const auto words = app.remaining(/*recurse=*/true);
  return words.empty() ? "" : words.front().substr(0, words.front().find('='));
}

// Returns the option or subcommand most similar to an unknown word; empty if none is similar.
std::string nearest_in(const CLI::App& app, const std::string& word) {
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
  return nearest_word(word, known);
}

int report_usage_error(const CLI::App& app, std::string text) {
  const CLI::App& command = chosen(app);
  const std::string unknown = unknown_word(app);
  const std::string meant = unknown.empty() ? "" : nearest_in(command, unknown);
  const std::string help =
      app.get_name() + (&command == &app ? "" : " " + command.get_name()) + " --help";
  if (!unknown.empty()) text = "\"" + unknown + "\" is unknown";
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
                       "Print the version and exit");
  app.set_help_flag("-h,--help", "Print common options and exit")->configurable(false);
  app.set_help_all_flag("--help-all", "Print all options and exit")->configurable(false);
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

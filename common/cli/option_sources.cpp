#include "common/cli/option_sources.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/cli/detail/help_format.hpp"

namespace multitetra {
namespace {

std::string environment_name(const CLI::Option& option) {
  std::string name = "MULTITETRA_" + option.get_single_name();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return c == '-' ? '_' : static_cast<char>(std::toupper(c));
  });
  return name;
}

// Returns the text as comment lines.
std::string commented(const std::string& text) {
  std::istringstream lines(wrapped(text, 98));
  std::string comment;
  for (std::string line; std::getline(lines, line);) comment += "# " + line + "\n";
  return comment;
}

// CLI11's markers of the beginning and end of a section.
bool is_section_mark(const CLI::ConfigItem& item) { return item.name == "++" || item.name == "--"; }

std::vector<CLI::ConfigItem> items_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) {
    throw UsageError("--config", "the file " + file.string() + " cannot be read.");
  }
  return CLI::ConfigTOML().from_config(stream);
}

CLI::Option& option_named(const CLI::App& command, const CLI::ConfigItem& item,
                          const std::filesystem::path& file) {
  for (const std::string& name : {"--" + item.name, item.name}) {
    const CLI::Option* const found = command.get_option_no_throw(name);
    if (found != nullptr && found->get_configurable() && item.parents.empty()) {
      return const_cast<CLI::Option&>(*found);  // CLI11 returns options of a const App as const.
    }
  }
  throw UsageError(file.string(), "there is no option \"" + item.fullname() +
                                      "\"; --print-config lists all options, without dashes.");
}

// Keeps URLs, recognized by their scheme.
std::string absolute_path(const std::string& text) {
  if (text.empty() || text.find("://") != std::string::npos) return text;
  return std::filesystem::absolute(text).lexically_normal().string();
}

void make_absolute(const CLI::App& command, const std::string& name) {
  const CLI::Option* found = command.get_option_no_throw("--" + name);
  if (found == nullptr) found = command.get_option_no_throw(name);
  if (found == nullptr || found->count() == 0) return;
  auto* const option = const_cast<CLI::Option*>(found);
  std::vector<std::string> paths = option->results();
  std::transform(paths.begin(), paths.end(), paths.begin(), &absolute_path);
  option->clear();
  option->add_result(std::move(paths));
}

}  // namespace

void add_option_sources(Command& command, OptionSources& sources) {
  for (CLI::Option* option :
       command.app().get_options([](const CLI::Option* o) { return o->get_configurable(); })) {
    option->envname(environment_name(*option));
  }
  command.begin_group();
  command
      .add_option(
          "--config", sources.config_file,
          "TOML file with options by their long names; overridden by flags and the environment")
      ->type_name("FILE")
      ->flag_only();
  command
      .add_flag("--print-config", sources.print_config,
                "Print the configuration with a comment for each key, and stop")
      ->flag_only();
}

void read_config_file(const Command& command, const std::filesystem::path& file) {
  std::set<std::string> seen;
  for (const CLI::ConfigItem& item : items_of(file)) {
    if (is_section_mark(item)) continue;
    CLI::Option& option = option_named(command.app(), item, file);
    if (!seen.insert(item.name).second) {
      throw UsageError(file.string(), "\"" + item.name + "\" is set twice.");
    }
    if (option.count() > 0) continue;
    try {
      option.add_result(item.inputs);
      option.run_callback();
    } catch (const CLI::ParseError& error) {
      throw UsageError(file.string(), error.what());
    }
  }
}

std::string config_text(const Command& command, const std::vector<std::string>& path_options) {
  for (const std::string& name : path_options) make_absolute(command.app(), name);
  std::istringstream lines(
      command.app().config_to_str(/*default_also=*/true, /*write_description=*/true));
  std::string text;
  // The comment of the command, of a group or of the next option.
  std::string comment;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) {
      text += comment;
      comment = (text.empty() ? "" : "\n") + commented(line.substr(1));
    } else if (!line.empty()) {
      // An option without a value is a comment, as an empty value would set it.
      text += comment + (line.ends_with("=\"\"") ? "# " : "") + line + "\n";
      comment.clear();
    }
  }
  return text;
}

}  // namespace multitetra

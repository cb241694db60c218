#include "common/cli/detail/help_format.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

namespace multitetra {
namespace {

constexpr std::size_t kColumn = 36;  // Where descriptions begin.
constexpr std::size_t kWidth = 100;

// Returns "0.1 to 86400" from a type name with a range; empty without.
std::string range_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find(" in [");
  const auto end = type.find(']', begin == std::string::npos ? 0 : begin);
  if (begin == std::string::npos || end == std::string::npos) return "";
  std::string range = type.substr(begin + 5, end - begin - 5);
  if (const auto dash = range.find(" - "); dash != std::string::npos)
    range.replace(dash, 3, " to ");
  return range;
}

// The footer's paragraph "Examples:", with indented lines, and the rest of the footer.
struct Footer {
  std::string examples;
  std::string rest;
};
Footer footer_of(const CLI::App& app) {
  Footer footer;
  std::istringstream lines(app.get_footer());
  bool is_example = false;
  for (std::string line; std::getline(lines, line);) {
    is_example = line == "Examples:" || (is_example && line.starts_with("  "));
    (is_example ? footer.examples : footer.rest) += line + "\n";
  }
  return footer;
}

// Returns the position of the first "; " or ". " outside of parentheses, or npos.
std::size_t end_of_first_clause(std::string_view text) {
  int open = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] == '(') ++open;
    if (text[i] == ')') --open;
    if (open <= 0 && (text[i] == ';' || text[i] == '.') && text[i + 1] == ' ') return i;
  }
  return std::string_view::npos;
}

// CLI11's group of options without an explicit group; its name depends on the version.
const std::string& everyday() {
  static const std::string kGroup = CLI::OptionDefaults().get_group();
  return kGroup;
}

bool is_rare(const CLI::Option* option) {
  return option->nonpositional() && !option->get_group().empty() &&
         option->get_group() != everyday();
}

// Of CLI11 it uses the lists of options and commands, but not its layout, which changes with the
// version.
class FullHelp : public CLI::Formatter {
 public:
  [[nodiscard]] std::string page(const CLI::App& app, const std::string& name,
                                 bool expands_commands) const {
    const Footer footer = footer_of(app);
    return app.get_description() + "\n" + usage(app, name) + "\n" + footer.examples +
           positionals(app) + groups(app) + commands(app, expands_commands) + "\n" + footer.rest;
  }

 protected:
  [[nodiscard]] virtual std::string groups(const CLI::App& app) const {
    std::string text;
    for (const std::string& group : app.get_groups()) {
      const auto options = app.get_options([&group](const CLI::Option* option) {
        return option->nonpositional() && option->get_group() == group;
      });
      if (group.empty() || options.empty()) continue;
      text += section(group == everyday() ? "Options" : group, options);
    }
    return text;
  }
  [[nodiscard]] virtual std::string value(const CLI::Option& option) const {
    return value_text(option);
  }
  [[nodiscard]] virtual std::string description(const CLI::Option& option) const {
    return full_description(option);
  }

  [[nodiscard]] std::string section(const std::string& title,
                                    const std::vector<const CLI::Option*>& options) const {
    std::string text = "\n" + title + ":\n";
    for (const CLI::Option* option : options) {
      const bool is_positional = !option->nonpositional();
      const std::string of_value = value(*option);
      text += row(option->get_name(is_positional, !is_positional) +
                      (of_value.empty() ? "" : " " + of_value) +
                      (option->get_required() ? " (required)" : ""),
                  wrapped(description(*option), kWidth - kColumn));
    }
    return text;
  }

 private:
  // Lines of `text` begin in the second column.
  static std::string row(const std::string& name, const std::string& text) {
    const std::string margin = "\n" + std::string(kColumn, ' ');
    std::string line = "  " + name;
    line += line.size() >= kColumn ? margin : std::string(kColumn - line.size(), ' ');
    for (const char c : text) line += c == '\n' ? margin : std::string(1, c);
    return line + "\n";
  }

  std::string usage(const CLI::App& app, const std::string& name) const {
    std::string text = "Usage: " + name + " [OPTIONS]";
    for (const CLI::Option* option : positional_options(app))
      text += " " + make_option_usage(option);
    if (commands_of(app).empty()) return text + "\n";
    return text + (app.get_require_subcommand_min() == 0 ? " [SUBCOMMAND]\n" : " SUBCOMMAND\n");
  }
  static std::vector<const CLI::Option*> positional_options(const CLI::App& app) {
    return app.get_options([](const CLI::Option* option) { return !option->nonpositional(); });
  }
  [[nodiscard]] std::string positionals(const CLI::App& app) const {
    const auto options = positional_options(app);
    return options.empty() ? "" : section("Positionals", options);
  }

  static std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands(
        [](const CLI::App* command) { return !command->get_group().empty(); });
  }
  [[nodiscard]] std::string commands(const CLI::App& app, bool expands) const {
    std::string text;
    for (const CLI::App* command : commands_of(app)) {
      text += expands ? expanded(*command) + "\n"
                      : row(command->get_name(), command->get_description());
    }
    return text.empty() ? "" : "\nSubcommands:\n" + text;
  }
  // Returns the options of a command, indented, without empty lines.
  [[nodiscard]] std::string expanded(const CLI::App& command) const {
    std::string text = command.get_name() + "\n";
    std::istringstream lines(command.get_description() + "\n" + positionals(command) +
                             groups(command));
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty()) text += "  " + line + "\n";
    }
    return text;
  }
};

class EverydayHelp : public FullHelp {
 protected:
  [[nodiscard]] std::string groups(const CLI::App& app) const override {
    const auto options = app.get_options([](const CLI::Option* option) {
      return option->nonpositional() && option->get_group() == everyday();
    });
    const std::string more = app.get_options(is_rare).empty() ? "" : "\nMore options: --help-all\n";
    return (options.empty() ? "" : section("Options", options)) + more;
  }

  [[nodiscard]] std::string value(const CLI::Option& option) const override {
    constexpr std::size_t kLongestValue = 24;
    std::string text = value_text(option);
    return text.size() > kLongestValue ? "WORD" : text;
  }

  [[nodiscard]] std::string description(const CLI::Option& option) const override {
    return short_description(option);
  }
};

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::All) return FullHelp().page(*app, name, true);
    return EverydayHelp().page(*app, name, false);
  }
};

}  // namespace

std::string value_text(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  std::string type = option.get_type_name();
  const auto begin = type.find('{');
  const auto end = type.find('}');
  if (begin != std::string::npos && end != std::string::npos) {
    std::replace(type.begin(), type.end(), ',', '|');
    return type.substr(begin + 1, end - begin - 1);
  }
  type = type.substr(0, type.find(':'));
  return type == "FLOAT" || type == "INT" || type == "UINT" ? "NUMBER" : type;
}

std::string short_description(const CLI::Option& option) {
  const std::string& default_text = option.get_default_str();
  const bool has_default = !default_text.empty() && default_text != "\"\"";
  const std::string& text = option.get_description();
  return text.substr(0, end_of_first_clause(text)) +
         (has_default ? " (default " + default_text + ")" : "");
}

std::string full_description(const CLI::Option& option) {
  std::string text = option.get_description();
  std::string more;
  const auto add = [&more](const std::string& words) {
    more += (more.empty() ? "" : "; ") + words;
  };
  if (const std::string range = range_of(option); !range.empty()) add(range);
  if (const std::string& default_text = option.get_default_str();
      !default_text.empty() && default_text != "\"\"") {
    add("default " + default_text);
  }
  if (!option.get_envname().empty()) add("or " + option.get_envname() + " in the environment");
  return more.empty() ? text : text + " (" + more + ")";
}

std::string wrapped(const std::string& text, std::size_t width) {
  std::string lines;
  // The columns used in the current line.
  std::size_t used = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (used > 0 && used + 1 + word.size() > width) {
      lines += "\n";
      used = 0;
    } else if (used > 0) {
      lines += " ";
      ++used;
    }
    lines += word;
    used += word.size();
  }
  return lines;
}

std::shared_ptr<CLI::Formatter> help_formatter() { return std::make_shared<HelpFormatter>(); }

}  // namespace multitetra

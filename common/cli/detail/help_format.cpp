#include "common/cli/detail/help_format.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

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

// CLI11's group of options without an explicit group.
constexpr const char* kEveryday = "Options";

bool is_rare(const CLI::Option* option) {
  return option->nonpositional() && !option->get_group().empty() &&
         option->get_group() != kEveryday;
}

// Prints all options, by group.
class FullHelp : public CLI::Formatter {
 public:
  FullHelp() { column_width(kColumn); }

  [[nodiscard]] std::string page(const CLI::App* app, const std::string& name,
                                 CLI::AppFormatMode mode) const {
    const Footer footer = footer_of(*app);
    return make_description(app) + make_usage(app, name) + "\n" + footer.examples +
           make_positionals(app) + groups(app, mode) + make_subcommands(app, mode) + "\n" +
           footer.rest;
  }

  [[nodiscard]] virtual std::string groups(const CLI::App* app, CLI::AppFormatMode mode) const {
    return make_groups(app, mode);
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    const std::string value = value_text(*option);
    return (value.empty() ? "" : " " + value) + (option->get_required() ? " (required)" : "");
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(full_description(*option), kWidth - kColumn);
  }
};

class EverydayHelp : public FullHelp {
 public:
  std::string groups(const CLI::App* app, CLI::AppFormatMode) const override {
    const auto options = app->get_options([](const CLI::Option* option) {
      return option->nonpositional() && option->get_group() == kEveryday;
    });
    const std::string more =
        app->get_options(is_rare).empty() ? "" : "\nMore options: --help-all\n";
    return (options.empty() ? "" : make_group(kEveryday, false, options)) + more;
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    constexpr std::size_t kLongestValue = 24;
    if (value_text(*option).size() > kLongestValue) return " WORD";
    return FullHelp::make_option_opts(option);
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(short_description(*option), kWidth - kColumn);
  }
};

class HelpFormatter : public FullHelp {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::Sub) return FullHelp::make_help(app, std::move(name), mode);
    if (mode == CLI::AppFormatMode::All) return page(app, name, mode);
    return EverydayHelp().page(app, name, mode);
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

#include "common/cli/detail/help_format.hpp"

#include <algorithm>
#include <sstream>

#include <CLI/CLI.hpp>

namespace multitetra {
namespace {

constexpr std::size_t kColumn = 30;  // Where descriptions begin.
constexpr std::size_t kWidth = 100;

// "[0.1 - 86400]" of a checked type's name; empty without.
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

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(kColumn); }

  std::string make_option_opts(const CLI::Option* option) const override {
    const std::string value = value_text(*option);
    return (value.empty() ? "" : " " + value) + (option->get_required() ? " (required)" : "");
  }

  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(full_description(*option), kWidth - kColumn);
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

std::string full_description(const CLI::Option& option) {
  std::string text = option.get_description();
  std::string more;
  const auto add = [&more](const std::string& words) {
    more += (more.empty() ? "" : "; ") + words;
  };
  if (const std::string range = range_of(option); !range.empty()) add(range);
  if (const std::string& usual = option.get_default_str(); !usual.empty() && usual != "\"\"") {
    add("default " + usual);
  }
  if (!option.get_envname().empty()) add("or " + option.get_envname() + " in the environment");
  return more.empty() ? text : text + " (" + more + ")";
}

std::string wrapped(const std::string& text, std::size_t width) {
  std::string lines;
  std::size_t used = 0;  // Of the line.
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

#include "common/cli/command_pages.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/cli/option_words.hpp"

namespace multitetra {
namespace {

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

// ---- bash

std::string identifier(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

// What completes the word behind an option, as one branch of `case "$previous"`.
std::string value_branch(const CLI::Option& option) {
  const std::string pattern = joined(names_of(option), "|");
  const std::vector<std::string> choices = choices_of(option);
  const std::string type = option.get_type_name();
  std::string act = ":";  // A number or a word of one's own: nothing to offer.
  if (!choices.empty()) {
    act = "COMPREPLY=($(compgen -W \"" + joined(choices, " ") + "\" -- \"$current\"))";
  } else if (type.starts_with("FILE")) {
    act = "COMPREPLY=($(compgen -f -- \"$current\"))";
  } else if (type.starts_with("DIR")) {
    act = "COMPREPLY=($(compgen -d -- \"$current\"))";
  }
  return "        " + pattern + ") " + act + "; return ;;\n";
}

std::string command_branch(const CLI::App& app, const std::string& pattern) {
  std::string values;
  std::vector<std::string> flags;
  for (const CLI::Option* option : options_of(app)) {
    if (option->get_positional()) continue;
    for (const std::string& name : names_of(*option)) flags.push_back(name);
    if (takes_value(*option)) values += value_branch(*option);
  }
  return "    " + pattern + ")\n      case \"$previous\" in\n" + values +
         "      esac\n      options=\"" + joined(flags, " ") + "\" ;;\n";
}

// ---- roff

// Text in which nothing is a command of roff.
std::string plain(std::string_view text) {
  std::string escaped;
  bool is_at_start = true;
  for (const char c : text) {
    if (is_at_start && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      escaped += c;
    }
    is_at_start = c == '\n';
  }
  return escaped;
}

std::string option_entry(const CLI::Option& option) {
  const std::string value = value_words(option);
  std::string entry = ".TP\n";
  if (option.get_positional()) {
    entry += "\\fI" + plain(option.get_single_name()) + "\\fR";
  } else {
    entry += "\\fB" + plain(joined(names_of(option), ", ")) + "\\fR";
    if (!value.empty()) entry += " \\fI" + plain(value) + "\\fR";
  }
  entry += "\n" + plain(full_description(option));
  return entry + "\n";
}

std::string options_text(const CLI::App& app) {
  std::vector<std::string> groups;
  for (const CLI::Option* option : options_of(app)) {
    if (std::find(groups.begin(), groups.end(), option->get_group()) == groups.end()) {
      groups.push_back(option->get_group());
    }
  }
  std::string text;
  for (const CLI::Option* option : options_of(app)) {
    if (option->get_positional()) text += option_entry(*option);
  }
  for (const std::string& group : groups) {
    std::string entries;
    for (const CLI::Option* option : options_of(app)) {
      if (!option->get_positional() && option->get_group() == group) {
        entries += option_entry(*option);
      }
    }
    if (entries.empty()) continue;
    if (groups.size() > 1) text += ".PP\n\\fI" + plain(group) + "\\fR\n";
    text += entries;
  }
  return text;
}

std::string footer_text(const CLI::App& app) {
  const std::string footer = app.get_footer();
  return footer.empty() ? "" : ".PP\n.nf\n" + plain(footer) + "\n.fi\n";
}

}  // namespace

std::string bash_completion(const Command& program) {
  const CLI::App& app = program.app();
  const std::string function = "_" + identifier(app.get_name());
  std::vector<std::string> names;
  std::string branches;
  for (const CLI::App* command : subcommands_of(app)) {
    names.push_back(command->get_name());
    branches += command_branch(*command, command->get_name());
  }
  const std::string commands = joined(names, " ");
  return "# Completion of " + app.get_name() + " for bash; made by " + app.get_name() +
         " --completion.\n" + function + "() {\n" +
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}\n"
         "  local command= options= word commands=\"" +
         commands +
         "\"\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    [[ \" $commands \" == *\" $word \"* ]] && { command=$word; break; }\n"
         "  done\n"
         "  case \"$command\" in\n" +
         branches + command_branch(app, "*") +
         "  esac\n"
         "  if [[ -z $command && -n $commands && $current != -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$commands\" -- \"$current\"))\n"
         "  elif [[ $current == -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$options\" -- \"$current\"))\n"
         "  else\n"
         "    COMPREPLY=($(compgen -f -- \"$current\"))\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F " +
         function + " " + app.get_name() + "\n";
}

std::string manual_page(const Command& program) {
  const CLI::App& app = program.app();
  std::string title = app.get_name();
  std::transform(title.begin(), title.end(), title.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  const auto commands = subcommands_of(app);
  std::string page = ".TH " + plain(title) + " 1 \"\" \"Multi\\-Tetra streaming " +
                     MULTITETRA_VERSION + "\"\n.SH NAME\n" + plain(app.get_name()) + " \\- " +
                     plain(app.get_description()) + "\n.SH SYNOPSIS\n.B " + plain(app.get_name()) +
                     (commands.empty() ? "\n[OPTIONS]\n" : "\n[OPTIONS] COMMAND ...\n") +
                     ".SH OPTIONS\n" + options_text(app);
  if (!commands.empty()) page += ".SH COMMANDS\n";
  for (const CLI::App* command : commands) {
    page += ".SS " + plain(app.get_name() + " " + command->get_name()) + "\n" +
            plain(command->get_description()) + ".\n" + options_text(*command) +
            footer_text(*command);
  }
  if (!app.get_footer().empty()) page += ".SH NOTES\n" + footer_text(app);
  return page;
}

}  // namespace multitetra

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/utf8.hpp"
#include "common/json/json_report.hpp"
#include "server/operations/access_list.hpp"
#include "server/operations/token_file.hpp"
#include "server/programs/commands.hpp"

namespace multitetra {
namespace {

struct TokenArguments {
  std::vector<std::string> words;  // NAME, or list, or revoke NAME.
  std::vector<std::string> datasets = {"*"};
  std::string file;
  std::string expires;
  bool surfaces_only = false;
  bool colors = false;
  bool replace = false;
  bool json = false;
};

// Parses "30d", "12h", or a time as in the file.
std::optional<AccessRights::Time> expiry_of(const std::string& text) {
  using namespace std::chrono;
  if (text.empty()) return std::nullopt;
  if (const auto time = time_from(text)) return *time;
  constexpr int kMaxCount = 36'500;
  std::string_view unit = text;
  const int count = take_number<int>(unit).value_or(0);
  if (count < 1 || count > kMaxCount || (unit != "d" && unit != "h")) {
    throw ExitError(kUsage, "--expires: \"" + text +
                                "\" is not a time; write days (30d), hours (12h), or a UTC time "
                                "(2027-01-31T12:00:00Z).");
  }
  const auto now = time_point_cast<seconds>(system_clock::now());
  return now + (unit == "d" ? hours(24 * count) : hours(count));
}

AccessList parsed(const std::string& file, const std::string& text) {
  auto list = parse_access_list(text);
  if (!list) throw std::runtime_error(file + ": " + list.error().text);
  return *std::move(list);
}

bool has_name(const AccessList& list, const std::string& name) {
  const auto is_it = [&](const AccessList::Entry& entry) { return entry.rights.name() == name; };
  return std::any_of(list.entries().begin(), list.entries().end(), is_it);
}

// Adds a line. A name has one token, so an existing one must be replaced explicitly.
void add_line(const TokenArguments& arguments, const std::string& name, const std::string& line) {
  TokenFile file(arguments.file, TokenFile::IfAbsent::kCreate);
  std::string text = file.text();
  if (has_name(parsed(arguments.file, text), name)) {
    if (!arguments.replace) {
      throw ExitError(kUsage,
                      "\"" + name + "\" already has a token in " + arguments.file +
                          "; --replace revokes it, and so does: multitetra-server token revoke " +
                          name + " --file " + arguments.file);
    }
    text = without_name(text, name).text;
  }
  if (!text.empty() && !text.ends_with('\n')) text += '\n';  // Some editors omit the last line end.
  file.replace(text + line + "\n");
}

int make_token(const TokenArguments& arguments) {
  const std::string& name = arguments.words.front();
  const auto expires = expiry_of(arguments.expires);
  for (const std::string& pattern : arguments.datasets) {
    if (pattern.find(',') == std::string::npos) continue;
    throw ExitError(kUsage, "--datasets: \"" + pattern +
                                "\" would be one name; repeat --datasets for several. In a name, ? "
                                "stands for a comma.");
  }
  const std::string token = new_token();
  const std::string line = access_line(name, token, arguments.datasets, expires,
                                       arguments.surfaces_only, arguments.colors);
  if (const auto made = parse_access_list(line); !made || made->size() != 1) {
    throw std::invalid_argument(
        "NAME and datasets must not contain spaces or begin with \"#\"; ? in a pattern matches any "
        "character.");
  }
  if (!arguments.file.empty()) add_line(arguments, name, line);
  if (arguments.json) {
    std::cout << text_of({{"name", name},
                          {"token", token},
                          {"line", line},
                          {"datasets", arguments.datasets},
                          {"surfaces_only", arguments.surfaces_only},
                          {"colors", !arguments.surfaces_only || arguments.colors},
                          {"expires", expires ? Json(time_text(*expires)) : Json(nullptr)}});
  } else if (arguments.file.empty()) {
    std::cout << "token: " << token << "\nline:  " << line << "\n";
  } else {
    std::cout << token << "\n";
  }
  return kOk;
}

Json json_of(const AccessRights& rights, bool has_token) {
  return {{"name", rights.name()},
          {"has_token", has_token},
          {"datasets", rights.datasets()},
          {"surfaces_only", rights.surfaces_only()},
          {"colors", rights.colors()},
          {"expires", rights.expires() ? Json(time_text(*rights.expires())) : Json(nullptr)},
          {"has_expired", rights.has_expired(std::chrono::system_clock::now())}};
}

std::string text_of_rights(const AccessRights& rights, bool has_token) {
  std::string text = printable(rights.name());
  for (const std::string& dataset : rights.datasets()) text += " " + printable(dataset);
  if (rights.surfaces_only()) {
    text += rights.colors() ? "  (surfaces and colors only)" : "  (surfaces only)";
  }
  if (!has_token) text += "  (clients without a token)";
  if (!rights.expires()) return text + "\n";
  const bool is_over = rights.has_expired(std::chrono::system_clock::now());
  return text + (is_over ? "  EXPIRED " : "  until ") + time_text(*rights.expires()) + "\n";
}

int list_tokens(const TokenArguments& arguments) {
  const AccessList list = parsed(arguments.file, TokenFile(arguments.file).text());
  Json tokens = Json::array();
  std::string text;
  const auto print_rights = [&](const AccessRights& rights, bool has_token) {
    tokens.push_back(json_of(rights, has_token));
    text += text_of_rights(rights, has_token);
  };
  for (const AccessList::Entry& entry : list.entries()) print_rights(entry.rights, true);
  for (const AccessRights& rights : list.anonymous()) print_rights(rights, false);
  std::cout << (arguments.json ? text_of({{"file", arguments.file}, {"tokens", tokens}}) : text);
  return kOk;
}

int revoke_token(const TokenArguments& arguments) {
  const std::string& name = arguments.words.back();
  TokenFile file(arguments.file);
  const NameRemoval without = without_name(file.text(), name);
  if (without.removed == 0) {
    throw std::runtime_error("The token file " + arguments.file + " has no token named \"" + name +
                             "\".");
  }
  file.replace(without.text);
  if (arguments.json) {
    std::cout << text_of({{"name", name}, {"file", arguments.file}, {"removed", without.removed}});
  } else {
    std::cout << printable(name) << " is no longer in " << printable(arguments.file)
              << "; running servers apply this after SIGHUP (systemctl reload multitetra)\n";
  }
  return kOk;
}

Run run_of(const std::shared_ptr<const TokenArguments>& a) {
  const std::string& verb = a->words.front();
  const std::size_t words = a->words.size();
  const bool is_list = verb == "list";
  const bool is_revoke = verb == "revoke";
  if (words != (is_revoke ? 2 : 1)) {
    throw UsageError("name", "give NAME, list, or revoke NAME.");
  }
  if ((is_list || is_revoke) && a->file.empty()) throw UsageError("--file", "give the token file.");
  if (is_list) return [a] { return list_tokens(*a); };
  if (is_revoke) return [a] { return revoke_token(*a); };
  return [a] { return make_token(*a); };
}

}  // namespace

void add_token_command(Command& program, Run& run) {
  const auto a = std::make_shared<TokenArguments>();
  Command* command = program.add_subcommand(
      "token", "Create, list and revoke access tokens, for `serve --tokens`");
  command
      ->add_option("name", a->words,
                   "NAME: create a token, with this name in the log; list: print all tokens; "
                   "revoke NAME: revoke the token")
      ->required()
      ->type_name("NAME|list|revoke NAME");
  command
      ->add_option("--datasets", a->datasets,
                   "Datasets that it gives access to; * matches any characters, ? one character "
                   "(repeatable)")
      ->capture_default_str();
  command
      ->add_option("--file,--append", a->file,
                   "Token file. A line for the new token is added, and only the token is printed; "
                   "a missing file is created, readable by its owner and, if root creates it, by "
                   "the group of its folder")
      ->type_name("FILE");
  command
      ->add_option("--expires", a->expires,
                   "When a new token expires, such as 30d; also 12h or 2027-01-31T12:00:00Z "
                   "(default: never)")
      ->type_name("WHEN");
  Option* const surfaces_only = command->add_flag(
      "--surfaces-only", a->surfaces_only,
      "It gives access to meshes only; not to samples (slices, probes, colors by fields)");
  command->add_flag("--colors", a->colors, "Also to colors by fields; these reveal samples")
      ->needs(surfaces_only);
  command->add_flag("--replace", a->replace, "Revoke the current token of NAME");
  command->add_flag("--json", a->json, "Print JSON");
  command->footer(
      "Examples:\n"
      "  multitetra-server token alice\n"
      "  token=$(multitetra-server token lab --datasets 'head-*' --file /etc/multitetra/tokens)\n"
      "  multitetra-server token guest --expires 30d --file tokens\n"
      "  multitetra-server token list --file tokens\n"
      "  multitetra-server token revoke alice --file tokens\n"
      "\n"
      "The token is printed once: the file contains only its SHA-256. Servers reload the file on\n"
      "SIGHUP; tokens expire without it.");
  command->callback([a, &run] { run = run_of(a); });
}

}  // namespace multitetra

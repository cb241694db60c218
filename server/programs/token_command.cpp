#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/cli/json_report.hpp"
#include "server/operations/access_list.hpp"
#include "server/programs/commands.hpp"

namespace multitetra {
namespace {

struct TokenArguments {
  std::string name;
  std::vector<std::string> datasets = {"*"};
  std::string append;
  bool json = false;
};

// Whether its last line has no end, as some editors leave it.
bool is_open_ended(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream || stream.tellg() <= 0) return false;
  stream.seekg(-1, std::ios::end);
  return stream.get() != '\n';
}

// Nobody but its owner reads a file that is made here.
void append_line(const std::filesystem::path& file, const std::string& line) {
  const bool is_new = !std::filesystem::exists(file);
  const std::string end_of_last = is_open_ended(file) ? "\n" : "";
  std::ofstream stream(file, std::ios::app);
  if (is_new && stream) {
    std::filesystem::permissions(
        file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  }
  stream << end_of_last << line << "\n" << std::flush;
  if (!stream) throw std::runtime_error("Cannot write to " + file.string() + ".");
}

int make_token(const TokenArguments& arguments) {
  const std::string token = new_token();
  const std::string line = access_line(arguments.name, token, arguments.datasets);
  if (const auto parsed = parse_access_list(line); !parsed || parsed->size() != 1) {
    throw std::invalid_argument(
        "NAME and datasets must be words: without spaces and \"#\" in "
        "front; ? in a pattern stands for any character.");
  }
  if (!arguments.append.empty()) append_line(arguments.append, line);
  if (arguments.json) {
    std::cout << text_of({{"name", arguments.name},
                          {"token", token},
                          {"line", line},
                          {"datasets", arguments.datasets}});
  } else if (arguments.append.empty()) {
    std::cout << "token: " << token << "\nline:  " << line << "\n";
  } else {
    std::cout << token << "\n";
  }
  return 0;
}

}  // namespace

void add_token_command(Command& program, Run& run) {
  const auto a = std::make_shared<TokenArguments>();
  Command* command = program.add_subcommand(
      "token", "Make a token for a client, and its line for the file of serve --tokens");
  command->add_option("name", a->name, "Whose it is, for the log")->required();
  command
      ->add_option("--datasets", a->datasets,
                   "What it lets one see: names, with * for any characters and ? for one "
                   "(repeatable)")
      ->capture_default_str();
  command
      ->add_option("--append", a->append,
                   "Write the line into this file, and print the token alone")
      ->type_name("FILE");
  command->add_flag("--json", a->json, "Print JSON");
  command->footer(
      "The token is shown this once: the file holds its SHA-256 only. Servers read the file again\n"
      "on SIGHUP. Examples:\n"
      "  multitetra-server token alice\n"
      "  token=$(multitetra-server token lab --datasets 'head-*' --append /etc/multitetra/tokens)");
  command->callback([a, &run] { run = [a] { return make_token(*a); }; });
}

}  // namespace multitetra

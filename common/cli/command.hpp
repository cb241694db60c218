// A command line, as programs describe theirs. CLI11 does the work and is seen by the sources of
// this folder alone: parsing thousands of templates once is enough.
//
//   Command program("Does this and that.", "multitetra-this");
//   std::string file;
//   program.add_option("-o,--output", file, "File to write")->required()->type_name("FILE");
//   program.footer("Examples:\n  multitetra-this -o out\n");
//   if (const auto code = parse_command_line(program, argc, argv)) return *code;
//
// Values are set when the line is parsed; what they are before is their default. They must outlive
// the parsing, options their command. Pointers are valid as long as the program.
//
// --help lists the options that have no group, for these are the everyday ones, each on one line:
// its description up to the first "; " or ". ". --help-all lists all, by group.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace multitetra {

// An invalid option that parsing cannot detect. Thrown by callbacks and reported like any other
// usage error: "--tcp: ...".
class UsageError : public std::runtime_error {
 public:
  UsageError(const std::string& option, const std::string& text)
      : std::runtime_error(option + ": " + text) {}
};

// Every function returns the option itself, for chaining.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option* one_of(const std::vector<std::string>& words);
  // int, double or std::size_t, which names the type in the help.
  template <typename Number>
  Option* within(Number least, Number most);
  Option* as_bytes();  // 500KiB, 2MiB
  Option* required();
  Option* expected(int count);
  Option* delimiter(char between);
  // Each time it is named it takes one value, and all of them count.
  Option* repeatable();
  Option* needs(const Option* other);
  Option* excludes(const std::string& other);
  // Cannot be set by --config or the environment.
  Option* flag_only();
  Option* envname(const std::string& variable);
  // The presentation in the help text.
  Option* type_name(const std::string& name);
  Option* group(const std::string& title);
  Option* capture_default_str();  // Shows its present value as the default.
  Option* default_text(const std::string& text);

 private:
  CLI::Option* option_;
};

class Command {
 public:
  // A program.
  Command(const std::string& description, const std::string& name);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  // T is a number, a string, std::optional<int> or <double>, or a vector of numbers or strings. A
  // name without dashes is that of a positional argument.
  template <typename T>
  Option* add_option(const std::string& names, T& value, const std::string& help);
  Option* add_flag(const std::string& names, bool& value, const std::string& help);
  // An option whose every value `parse` takes, or says what is wrong with it, such as "must be
  // voxel or world". A switch has no value behind it, and is parsed as "on".
  using Parse = std::function<std::optional<std::string>(const std::string& text)>;
  Option* add_parsed(const std::string& names, Parse parse, const std::string& help);
  Option* add_switch(const std::string& names, Parse parse, const std::string& help);
  [[nodiscard]] Option option(const std::string& name);  // One that there is.
  Command* add_subcommand(const std::string& name, const std::string& description);
  void require_subcommand();
  // The group of the options that are added from now on, unless they have one of their own; none:
  // they are everyday options.
  void begin_group(const std::string& title = "Options");
  // What follows the options in --help; a paragraph "Examples:" in it, whose lines are indented,
  // precedes them.
  void footer(std::string text);
  // Called after parsing if this command was chosen. May throw UsageError.
  void callback(std::function<void()> parsed);

  [[nodiscard]] bool got_subcommand(const std::string& name) const;

  // For the sources that know CLI11.
  [[nodiscard]] CLI::App& app() { return *app_; }
  [[nodiscard]] const CLI::App& app() const { return *app_; }

 private:
  explicit Command(CLI::App& app);
  Option* added(CLI::Option& option);

  // The program's parser, which owns those of subcommands.
  std::unique_ptr<CLI::App> own_;
  CLI::App* app_;
  std::vector<std::unique_ptr<Option>> options_;
  std::vector<std::unique_ptr<Command>> subcommands_;
};

}  // namespace multitetra

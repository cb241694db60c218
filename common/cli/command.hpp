// A command line, as declared by programs. Wraps CLI11, which only the sources of this folder
// include: its thousands of templates are compiled once.
//
//   Command program("Does this and that.", "multitetra-this");
//   std::string file;
//   program.add_option("-o,--output", file, "File to write")->required()->type_name("FILE");
//   program.footer("Examples:\n  multitetra-this -o out\n");
//   if (const auto code = parse_command_line(program, argc, argv)) return *code;
//
// Values are set during parsing; their previous values are the defaults. They must outlive the
// parsing, and options their command. Pointers are valid as long as the program's Command.
//
// --help lists the everyday options, those without a group, each on one line with its description
// up to the first "; " or ". ". --help-all lists all, by group.
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

// An invalid option that parsing cannot detect. Thrown by callbacks and reported like other usage
// errors: "--tcp: ...".
class UsageError : public std::runtime_error {
 public:
  UsageError(const std::string& option, const std::string& text)
      : std::runtime_error(option + ": " + text) {}
};

// All functions return the option itself, for chaining.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option* one_of(const std::vector<std::string>& words);
  // Accepts only numbers of this range: int, double or std::size_t, which the help shows.
  template <typename Number>
  Option* within(Number least, Number most);
  // Accepts 500KiB, 2MiB.
  Option* as_bytes();
  Option* required();
  Option* expected(int count);
  Option* delimiter(char between);
  // May be given several times, with one value each.
  Option* repeatable();
  Option* needs(const Option* other);
  Option* excludes(const std::string& other);
  // Makes the option settable on the command line only, not by --config or the environment.
  Option* flag_only();
  Option* envname(const std::string& variable);
  // The presentation in the help text:
  Option* type_name(const std::string& name);
  Option* group(const std::string& title);
  Option* capture_default_str();  // Shows the current value as the default.
  Option* default_text(const std::string& text);

 private:
  CLI::Option* option_;
};

class Command {
 public:
  // The top-level command of a program.
  Command(const std::string& description, const std::string& name);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  // T is a number, a string, std::optional<int> or <double>, or a vector of numbers or strings.
  // Names without dashes declare positional arguments.
  template <typename T>
  Option* add_option(const std::string& names, T& value, const std::string& help);
  Option* add_flag(const std::string& names, bool& value, const std::string& help);
  // Adds an option whose values are passed to `parse`, which returns nullopt or what is wrong, such
  // as "must be voxel or world". A switch has no value and is parsed as "on".
  using Parse = std::function<std::optional<std::string>(const std::string& text)>;
  Option* add_parsed(const std::string& names, Parse parse, const std::string& help);
  Option* add_switch(const std::string& names, Parse parse, const std::string& help);
  // Requires that the option exists.
  [[nodiscard]] Option option(const std::string& name);
  Command* add_subcommand(const std::string& name, const std::string& description);
  void require_subcommand();
  // Sets the group of the options added from now on; the default is that of everyday options.
  void begin_group(const std::string& title = "Options");
  // Sets the text after the options in --help. A paragraph "Examples:" in it, with indented lines,
  // is moved before them.
  void footer(std::string text);
  // Called after parsing if this command was chosen. May throw UsageError.
  void callback(std::function<void()> parsed);

  [[nodiscard]] bool got_subcommand(const std::string& name) const;

  // Returns the CLI11 object, for sources that include CLI11.
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

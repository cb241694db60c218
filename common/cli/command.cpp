#include "common/cli/command.hpp"

#include <cstdint>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>

namespace multitetra {

// ---- options

Option* Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return this;
}

template <typename Number>
Option* Option::within(Number least, Number most) {
  option_->check(CLI::Range(least, most));
  return this;
}
template Option* Option::within(int, int);
template Option* Option::within(double, double);
template Option* Option::within(std::size_t, std::size_t);

Option* Option::as_bytes() {
  option_->transform(CLI::AsSizeValue(/*kb_is_1000=*/false));
  return this;
}

Option* Option::required() {
  option_->required();
  return this;
}

Option* Option::expected(int count) {
  option_->expected(count);
  return this;
}

Option* Option::delimiter(char between) {
  option_->delimiter(between);
  return this;
}

Option* Option::repeatable() {
  option_->expected(1);
  option_->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return this;
}

Option* Option::needs(const Option* other) {
  option_->needs(other->option_);
  return this;
}

Option* Option::excludes(const std::string& other) {
  option_->excludes(other);
  return this;
}

Option* Option::flag_only() {
  option_->configurable(false);
  return this;
}

Option* Option::envname(const std::string& variable) {
  option_->envname(variable);
  return this;
}

Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}

Option* Option::group(const std::string& title) {
  option_->group(title);
  return this;
}

Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}

Option* Option::default_text(const std::string& text) {
  option_->default_str(text);
  return this;
}

// ---- commands

Command::Command(const std::string& description, const std::string& name)
    : own_(std::make_unique<CLI::App>(description, name)), app_(own_.get()) {}
Command::Command(CLI::App& app) : app_(&app) {}
Command::~Command() = default;

Option* Command::added(CLI::Option& option) {
  return options_.emplace_back(std::make_unique<Option>(option)).get();
}

template <typename T>
Option* Command::add_option(const std::string& names, T& value, const std::string& help) {
  return added(*app_->add_option(names, value, help));
}
template Option* Command::add_option(const std::string&, std::string&, const std::string&);
template Option* Command::add_option(const std::string&, double&, const std::string&);
template Option* Command::add_option(const std::string&, std::int32_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option* Command::add_option(const std::string&, std::optional<double>&,
                                     const std::string&);
template Option* Command::add_option(const std::string&, std::vector<std::string>&,
                                     const std::string&);
template Option* Command::add_option(const std::string&, std::vector<double>&, const std::string&);
template Option* Command::add_option(const std::string&, std::vector<std::int32_t>&,
                                     const std::string&);

Option* Command::add_flag(const std::string& names, bool& value, const std::string& help) {
  return added(*app_->add_flag(names, value, help));
}

Option* Command::add_parsed(const std::string& names, Parse parse, const std::string& help) {
  const std::string name = names.substr(names.rfind(',') + 1);
  const CLI::callback_t callback = [name, parse = std::move(parse)](const CLI::results_t& texts) {
    for (const std::string& text : texts) {
      if (const auto wrong = parse(text)) throw CLI::ValidationError(name + " " + text, *wrong);
    }
    return true;
  };
  return added(*app_->add_option(names, callback, help));
}

Option* Command::add_switch(const std::string& names, Parse parse, const std::string& help) {
  return added(*app_->add_flag_callback(
      names, [parse = std::move(parse)] { (void)parse("on"); }, help));
}

Option Command::option(const std::string& name) { return Option(*app_->get_option(name)); }

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  CLI::App& app = *app_->add_subcommand(name, description);
  return subcommands_.emplace_back(std::unique_ptr<Command>(new Command(app))).get();
}

void Command::begin_group(const std::string& title) { app_->option_defaults()->group(title); }
void Command::require_subcommand() { app_->require_subcommand(1); }
void Command::footer(std::string text) { app_->footer(std::move(text)); }
void Command::callback(std::function<void()> parsed) { app_->callback(std::move(parsed)); }
bool Command::got_subcommand(const std::string& name) const { return app_->got_subcommand(name); }

}  // namespace multitetra

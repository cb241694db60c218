// Help, version and errors of command lines.
#include "common/cli/command_line.hpp"

#include <array>
#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <CLI/CLI.hpp>

#include "common/cli/detail/help_format.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/terminal.hpp"

namespace multitetra {
namespace {

// A program with options of all kinds.
class Tools {
 public:
  Tools() : app_("Cuts and joins.", "tools") {
    app_.require_subcommand();
    add_program_flags(app_);
    Command* cut = app_.add_subcommand("cut", "Cut something");
    cut->add_option("--edge", edge_, "How it is cut")
        ->one_of({"sharp", "blunt"})
        ->capture_default_str();
    cut->add_option("--depth", depth_, "How deep")->type_name("MM");
    cut->add_option("what", file_, "What is cut")->type_name("FILE")->required();
    cut->footer("Examples:\n  tools cut .paper\n");
    app_.add_subcommand("join", "Join things")->add_flag("--quiet", quiet_, "Say nothing");
  }

  std::optional<int> parse(std::vector<std::string> words) {
    words.insert(words.begin(), "tools");
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    return parse_command_line(app_, static_cast<int>(pointers.size()), pointers.data());
  }
  const Command& app() const { return app_; }

 private:
  Command app_;
  std::string edge_ = "sharp";
  double depth_ = 1;
  std::string file_;
  bool quiet_ = false;
};

std::string told_by(const std::vector<std::string>& words, int code) {
  Tools tools;
  ::testing::internal::CaptureStderr();
  const auto got = tools.parse(words);
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(got, std::optional<int>(code)) << text;
  return text;
}

TEST(CommandLine, ContinuesAfterAValidLine) {
  EXPECT_EQ(Tools().parse({"cut", "--edge", "blunt", "paper"}), std::nullopt);
}

TEST(CommandLine, SuggestsTheNearestWord) {
  EXPECT_NE(told_by({"cut", "--ege", "blunt", "paper"}, 2).find("Did you mean --edge?"),
            std::string::npos);
  EXPECT_NE(told_by({"joni"}, 2).find("Did you mean join?"), std::string::npos);
  const std::string far = told_by({"cut", "--zzzzzzz", "paper"}, 2);
  EXPECT_EQ(far.find("Did you mean"), std::string::npos);
  EXPECT_NE(far.find("tools cut --help"), std::string::npos);
}

TEST(CommandLine, PrintsHelpWithoutArguments) {
  const std::string text = told_by({}, 2);
  EXPECT_NE(text.find("cut"), std::string::npos);
  EXPECT_NE(text.find("join"), std::string::npos);
}

TEST(CommandLine, EndsWithZeroAfterHelpAndVersion) {
  for (const char* page : {"--help", "--version", "--help-all"}) {
    Tools tools;
    ::testing::internal::CaptureStdout();
    EXPECT_EQ(tools.parse({page}), std::optional<int>(0)) << page;
    EXPECT_FALSE(::testing::internal::GetCapturedStdout().empty()) << page;
  }
}

TEST(HelpFormat, ShowsTypeChoicesRangeAndDefault) {
  CLI::App app;
  double number = 3;
  std::string word = "on";
  bool is_set = false;
  CLI::Option* const how_many = app.add_option("-n,--number", number, "How many")
                                    ->check(CLI::Range(1.0, 9.0))
                                    ->envname("NUMBER_OF_THEM")
                                    ->capture_default_str();
  CLI::Option* const which = app.add_option("--word", word, "Which")->check(CLI::IsMember({"on"}));
  CLI::Option* const flag = app.add_flag("--flag", is_set, "Whether");
  EXPECT_EQ(value_text(*how_many), "NUMBER");
  EXPECT_EQ(value_text(*which), "on");
  EXPECT_EQ(value_text(*flag), "");
  EXPECT_EQ(full_description(*how_many),
            "How many (1 to 9; default 3; or NUMBER_OF_THEM in the environment)");
  EXPECT_EQ(full_description(*flag), "Whether");
}

TEST(HelpFormat, ShortLinesHaveBalancedParentheses) {
  CLI::App app;
  double number = 3;
  const auto line = [&](const std::string& name, const std::string& description) {
    return short_description(*app.add_option("--" + name, number, description));
  };
  EXPECT_EQ(line("a", "Layers (default: 0; 1 for labels)"), "Layers (default: 0; 1 for labels)");
  EXPECT_EQ(line("b", "Files (.mtd. or .nrrd; (s3: a; b)) to read; more"),
            "Files (.mtd. or .nrrd; (s3: a; b)) to read");
  EXPECT_EQ(line("c", "Brief. More (a; b)"), "Brief");
  EXPECT_EQ(line("d", "1) one; two"), "1) one");
  CLI::Option* const known = app.add_option("--e", number, "Depth (in mm; or cm); of a cut");
  known->capture_default_str();
  EXPECT_EQ(short_description(*known), "Depth (in mm; or cm) (default 3)");
}

TEST(HelpFormat, WrapsLines) {
  EXPECT_EQ(wrapped("one two three", 8), "one two\nthree");
  EXPECT_EQ(wrapped("a longer-than-allowed b", 6), "a\nlonger-than-allowed\nb");
}

TEST(Terminal, UsesNoColorsInAFile) {
  EXPECT_EQ(styled(Style::kRed, "words", /*descriptor=*/-1), "words");
}

TEST(HumanUnits, ChooseReadableUnits) {
  EXPECT_EQ(human_seconds(0.0004), "0.4 ms");
  EXPECT_EQ(human_seconds(0.024), "24 ms");
  EXPECT_EQ(human_seconds(1.254), "1.25 s");
  EXPECT_EQ(human_seconds(59.4), "59.4 s");
  EXPECT_EQ(human_seconds(185), "3 min 05 s");
  EXPECT_EQ(human_seconds(5400), "1 h 30 min");
  EXPECT_EQ(human_count(1'234'567), "1 234 567");
  EXPECT_EQ(human_bytes(1536), "1.5 KiB");
  EXPECT_EQ(human_count_of(1, "tile"), "1 tile");
  EXPECT_EQ(human_count_of(1234, "tile"), "1 234 tiles");
  EXPECT_EQ(human_speed(0.0456), "0.046");
  EXPECT_EQ(human_speed(3.16), "3.2");
  EXPECT_EQ(human_speed(1234.5), "1 234");
}

}  // namespace
}  // namespace multitetra

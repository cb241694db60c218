// Exit codes of programs, and escaping of untrusted text in their output.
#include "common/cli/program.hpp"

#include <gtest/gtest.h>

#include <iostream>
#include <new>
#include <stdexcept>

#include "common/base/exit_codes.hpp"
#include "common/cli/terminal.hpp"

namespace multitetra {
namespace {

struct Ended {
  int code = 0;
  std::string output;
};
Ended ended(const std::function<int()>& body) {
  ::testing::internal::CaptureStderr();
  const int code = run_program("multitetra-this", body);
  return {code, ::testing::internal::GetCapturedStderr()};
}

TEST(Program, ExitsWithTheCodeOfTheException) {
  EXPECT_EQ(ended([] { return 3; }).code, 3);
  const Ended no_secrets = ended([]() -> int { throw ExitError(kBadCredentials, "No key."); });
  EXPECT_EQ(no_secrets.code, kBadCredentials);
  EXPECT_EQ(no_secrets.output, "multitetra-this: No key.\n");
  EXPECT_EQ(ended([]() -> int { throw std::runtime_error("Oh."); }).code, kFailed);
  EXPECT_EQ(ended([]() -> int { throw std::invalid_argument("--size"); }).code, kUsage);
}

TEST(Program, ReportsOutOfMemoryInASentence) {
  const Ended out = ended([]() -> int { throw std::bad_alloc(); });
  EXPECT_EQ(out.code, kFailed);
  EXPECT_NE(out.output.find("Not enough memory"), std::string::npos) << out.output;
  EXPECT_EQ(out.output.find("bad_alloc"), std::string::npos) << out.output;
}

TEST(Program, FailsWhenStandardOutputFails) {
  const Ended out = ended([] {
    std::cout.setstate(std::ios::badbit);
    return 0;
  });
  std::cout.clear();
  EXPECT_EQ(out.code, kFailed);
  EXPECT_NE(out.output.find("standard output"), std::string::npos) << out.output;
}

TEST(Program, EscapesForeignTextForTheTerminal) {
  EXPECT_EQ(ended([]() -> int { throw std::runtime_error("a\033]0;owned\007b"); }).output,
            "multitetra-this: a\\x1b]0;owned\\x07b\n");
}

TEST(Printable, KeepsTextAndEscapesControlCharacters) {
  EXPECT_EQ(printable("größe 3 µm\nnext"), "größe 3 µm\nnext");
  EXPECT_EQ(printable("\x1b[2J\r\t\x7f"), "\\x1b[2J\\x0d\\x09\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "\\xc2\\x9b2J")
      << "CSI as one character";
  EXPECT_EQ(printable("\xc2"), "\\xc2") << "no UTF-8";
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(printable(""), "");
  EXPECT_EQ(printable("a\u202Eb\u2066c\u061Cd"), "a\\xe2\\x80\\xaeb\\xe2\\x81\\xa6c\\xd8\\x9cd");
  EXPECT_EQ(printable("a\nb", /*keeps_lines=*/false), "a\\x0ab");
}

TEST(TextTable, AlignsColumnsToTheirWidestCells) {
  EXPECT_EQ(text_table({{"a", "bb", "c"}, {"long", "", "d"}, {"e", "f", ""}}),
            "a     bb  c\n"
            "long      d\n"
            "e     f\n");
}

}  // namespace
}  // namespace multitetra

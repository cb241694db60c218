#include "server/operations/access_list.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

AccessList parsed(const std::string& text) {
  auto list = parse_access_list(text);
  if (!list) throw std::runtime_error(list.error().text);
  return *std::move(list);
}

TEST(AccessList, GrantsTheRightsOfTheTokensLine) {
  const AccessList list = parsed(access_line("alice", "secret-a", {"head-*", "embryo"}) + "\n" +
                                 access_line("bob", "secret-b", {"*"}) + "\n");
  const auto alice = list.rights_of("secret-a");
  ASSERT_TRUE(alice);
  EXPECT_EQ(alice->name(), "alice");
  EXPECT_TRUE(alice->may_see("head-1"));
  EXPECT_TRUE(alice->may_see("embryo"));
  EXPECT_FALSE(alice->may_see("embryo-2"));
  EXPECT_FALSE(alice->may_see("foot"));
  ASSERT_TRUE(list.rights_of("secret-b"));
  EXPECT_TRUE(list.rights_of("secret-b")->may_see("foot"));
}

TEST(AccessList, RejectsUnknownTokens) {
  const AccessList list = parsed(access_line("alice", "secret", {"*"}));
  for (const std::string& token :
       std::vector<std::string>{"", "secre", "secret ", "Secret", "alice"}) {
    const auto rights = list.rights_of(token);
    ASSERT_FALSE(rights) << token;
    EXPECT_EQ(rights.error().code, ErrorCode::kUnauthenticated);
  }
  EXPECT_FALSE(parsed("").rights_of(""));
  EXPECT_FALSE(parsed("").rights_of("secret"));
}

TEST(AccessList, AppliesLinesWithoutTokenToAnonymousClients) {
  const AccessList list = parsed("guests none public-*\n" + access_line("a", "secret", {"*"}));
  const auto guest = list.rights_of("");
  ASSERT_TRUE(guest);
  EXPECT_TRUE(guest->may_see("public-1"));
  EXPECT_FALSE(guest->may_see("private"));
  EXPECT_FALSE(list.rights_of("none"));
  EXPECT_FALSE(list.rights_of("wrong")) << "A wrong token is no token of a guest.";
}

TEST(AccessList, ReadsSurfacesOnlyLines) {
  const AccessList list =
      parsed(access_line("alice", "a", {"*"}, {}, /*surfaces_only=*/true) + "\n" +
             access_line("bob", "b", {"*"}) + "\nguests none public-* only=surfaces\n");
  EXPECT_TRUE(list.rights_of("a")->surfaces_only());
  EXPECT_FALSE(list.rights_of("a")->colors());
  const AccessList colored = parsed(access_line("alice", "a", {"*"}, {}, true, /*colors=*/true));
  EXPECT_TRUE(colored.rights_of("a")->surfaces_only());
  EXPECT_TRUE(colored.rights_of("a")->colors());
  EXPECT_FALSE(list.rights_of("b")->surfaces_only());
  EXPECT_TRUE(list.rights_of("")->surfaces_only());
  EXPECT_TRUE(list.rights_of("")->may_see("public-1"));
  EXPECT_FALSE(parse_access_list(access_line("alice", "a", {}, {}, true)));
}

TEST(AccessList, HashesTokensWithSha256) {
  EXPECT_EQ(access_line("a", "abc", {"*"}),
            "a ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad *");
}

TEST(AccessList, IgnoresCommentsEmptyLinesAndCase) {
  std::string line = access_line("a", "abc", {"head"});
  std::transform(line.begin() + 2, line.begin() + 66, line.begin() + 2,
                 [](char c) { return static_cast<char>(std::toupper(c)); });
  const AccessList list = parsed("# who\n\n   \t\r\n" + line + "  # of the lab\r\n");
  ASSERT_EQ(list.size(), 1U);
  EXPECT_TRUE(list.rights_of("abc")->may_see("head"));
  EXPECT_FALSE(list.rights_of("abc")->may_see("of"));
}

TEST(AccessList, ReportsTheLineNumberOfAnInvalidLine) {
  const std::string good = access_line("a", "abc", {"*"});
  const std::string one_short = "a " + good.substr(3) + "\n";
  for (const std::string& bad :
       {std::string("a\n"), std::string("a none\n"), std::string("a abc *\n"), one_short,
        "a g" + good.substr(3) + "\n", std::string("guests none *\n")}) {
    const auto list = parse_access_list("guests none *\n" + good + "\n" + bad);
    ASSERT_FALSE(list) << bad;
    EXPECT_EQ(list.error().code, ErrorCode::kInvalidArgument);
    EXPECT_TRUE(list.error().text.starts_with("Line 3 ")) << list.error().text;
  }
}

TEST(AccessList, GeneratesLongUniqueTokens) {
  const std::string token = new_token();
  EXPECT_GE(token.size(), 64U);
  EXPECT_NE(token, new_token());
  EXPECT_TRUE(parsed(access_line("a", token, {"*"})).rights_of(token));
}

TEST(AccessList, NamesTheUnreadableOrInvalidFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(load_access_list(folder.file("good", access_line("a", "abc", {"*"})))->size(), 1U);
  EXPECT_EQ(load_access_list(folder.file("empty", ""))->size(), 0U);
  for (const auto& file :
       {folder.path() / "none", folder.path(), folder.file("bad", "one two\n")}) {
    try {
      (void)load_access_list(file);
      ADD_FAILURE() << file;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos) << error.what();
    }
  }
}

TEST(AccessRights, AllowEverythingByDefault) {
  EXPECT_TRUE(AccessRights().may_see("anything"));
  EXPECT_FALSE(AccessRights("a", {}).may_see("anything"));
}

TEST(Patterns, MatchAnyTextWithAStarAndOneCharacterWithAQuestionMark) {
  for (const auto& [pattern, text] :
       std::vector<std::pair<const char*, const char*>>{{"*", ""},
                                                        {"*", "abc"},
                                                        {"abc", "abc"},
                                                        {"a*", "a"},
                                                        {"a*c", "abbc"},
                                                        {"a?c", "abc"},
                                                        {"*b*", "abc"},
                                                        {"**", "x"},
                                                        {"a*b*c", "aXbYbc"},
                                                        {"*ab", "aab"}}) {
    EXPECT_TRUE(matches(pattern, text)) << pattern << " " << text;
  }
  for (const auto& [pattern, text] :
       std::vector<std::pair<const char*, const char*>>{{"", "a"},
                                                        {"abc", "abcd"},
                                                        {"abc", "ab"},
                                                        {"a?", "a"},
                                                        {"?", ""},
                                                        {"a*c", "ab"},
                                                        {"*ab", "aba"},
                                                        {"head-*", "Head-1"}}) {
    EXPECT_FALSE(matches(pattern, text)) << pattern << " " << text;
  }
}

// Backtracking over all stars would take exponential time here.
TEST(Patterns, MatchManyStarsWithoutBacktracking) {
  std::string pattern;
  for (int i = 0; i < 100; ++i) pattern += "a*";
  EXPECT_FALSE(matches(pattern + "b", std::string(10'000, 'a')));
}

TEST(AccessList, ExpiresTokensAtTheirTime) {
  const auto end = time_from("2027-01-31T12:00:00Z").value();
  const AccessList list = parsed(access_line("alice", "secret", {"head-*"}, end) +
                                 "\nguests none public expires=2027-01-31T12:00:00Z\n");
  for (const std::string token : {"secret", ""}) {
    EXPECT_TRUE(list.rights_of(token, end - std::chrono::seconds(1))) << token;
    const auto late = list.rights_of(token, end);
    ASSERT_FALSE(late) << token;
    EXPECT_EQ(late.error().code, ErrorCode::kUnauthenticated);
  }
  EXPECT_NE(list.rights_of("secret", end).error().text.find("expired at 2027-01-31T12:00:00Z"),
            std::string::npos);
  EXPECT_FALSE(list.rights_of("secret", end - std::chrono::hours(1))->may_see("expires=2027"));
  const AccessList expired = parsed(access_line("alice", "secret", {"*"}, AccessRights::Time{}));
  EXPECT_EQ(expired.owner_of("secret"), "alice") << "for the log";
  EXPECT_EQ(expired.owner_of("other"), "");
  EXPECT_EQ(expired.owner_of(""), "");
}

TEST(AccessList, AcceptsExpiryCenturiesAhead) {
  const auto end = time_from("2400-01-01T00:00:00Z");
  ASSERT_TRUE(end);
  const auto list = parse_access_list(access_line("a", "secret", {"*"}, end)).value();
  EXPECT_TRUE(list.rights_of("secret"));
}

TEST(AccessList, AcceptsOnlyValidUtcTimes) {
  for (const std::string good :
       {"2027-01-31T12:00:00Z", "1970-01-01T00:00:00Z", "2400-02-29T23:59:59Z"}) {
    EXPECT_EQ(time_text(time_from(good).value()), good);
  }
  for (const std::string bad : {"", "2027-01-31", "2027-02-31T12:00:00Z", "2027-01-31T12:00:00",
                                "2027-01-31T12:00:00Z ", "tomorrow"}) {
    EXPECT_FALSE(time_from(bad)) << bad;
    const auto list = parse_access_list(access_line("a", "x", {"*"}) + " expires=" + bad);
    if (bad.ends_with(' ')) continue;  // Spaces separate words.
    EXPECT_FALSE(list) << bad;
  }
  EXPECT_FALSE(parse_access_list(access_line("a", "x", {}, time_from("2027-01-31T12:00:00Z"))))
      << "no datasets";
}

TEST(AccessList, KeepsOtherEntriesAndCommentsWhenANameIsRemoved) {
  const std::string alice = access_line("alice", "a", {"*"}) + "\n";
  const std::string bob = access_line("bob", "b", {"*"});
  const auto without = without_name("# alice\n" + alice + "\n" + alice + bob, "alice");
  EXPECT_EQ(without.text, "# alice\n\n" + bob);
  EXPECT_EQ(without.removed, 2U);
  EXPECT_EQ(without_name(bob, "bo").removed, 0U);
  EXPECT_EQ(without_name("", "bob").text, "");
}

}  // namespace
}  // namespace multitetra

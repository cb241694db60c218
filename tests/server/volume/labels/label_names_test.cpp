// Names and colors of labels in two text formats, and errors for invalid lines.
#include "server/volume/labels/label_names.hpp"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <fstream>
#include <random>
#include <string>

#include "server/volume/formats/stored_volume.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using testing::expect_contains;

constexpr const char* kSnap =
    "################################################\n"
    "# ITK-SnAP Label Description File\n"
    "    0     0    0    0        0  0  0    \"Clear Label\"\r\n"
    "    3   221  130  101        1  1  1    \"liver, \xc3\xa0 gauche\"\n";
constexpr const char* kTable =
    "# Color table file\n"
    "\n"
    "0 Background 0 0 0 0\n"
    "3\tliver 221 130 101 255\n"
    "7 \"two words\" 1 2 3\n"
    "-2 2 1 2 3";

TEST(LabelNames, ReadItkSnapFiles) {
  const auto labels = parse_label_names(kSnap);
  ASSERT_TRUE(labels) << labels.error().text;
  EXPECT_EQ(*labels, (std::vector<Label>{
                         {.value = 0, .name = "Clear Label", .color = 0},
                         {.value = 3, .name = "liver, \xc3\xa0 gauche", .color = 0xdd8265}}));
}

TEST(LabelNames, ReadSlicerAndFreeSurferFiles) {
  const auto labels = parse_label_names(kTable);
  ASSERT_TRUE(labels) << labels.error().text;
  EXPECT_EQ(*labels, (std::vector<Label>{{.value = 0, .name = "Background", .color = 0},
                                         {.value = 3, .name = "liver", .color = 0xdd8265},
                                         {.value = 7, .name = "two words", .color = 0x010203},
                                         {.value = -2, .name = "2", .color = 0x010203}}));
}

TEST(LabelNames, NameTheLineAndTheFixInErrors) {
  for (const char* line : {"x liver 1 2 3", "3 liver 1 2", "3 liver 1 2 256", "3 liver 1 2 -1",
                           "3 liver 1 2 3 4 5", "3 \"liver 1 2 3", "3.5 liver 1 2 3",
                           "3 liv\x01"
                           "er 1 2 3",
                           "3 \xff 1 2 3", "3 liver 1 2 3 x", "3 1 2 3 1 1 1 liver",
                           "99999999999999999999 liver 1 2 3", "9007199254740993 liver 1 2 3 x",
                           "\"3\" liver 1 2 3", "3"}) {
    const auto labels = parse_label_names("# first\n1 one 1 1 1\n" + std::string(line) + "\n");
    ASSERT_FALSE(labels) << line;
    expect_contains(labels.error().text, "line 3 is not a label such as '3 liver 221 130 101 255'");
  }
  const auto twice = parse_label_names("1 one 1 1 1\n1 two 1 1 1\n");
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().text, "line 2 lists label 1 a second time");
  EXPECT_FALSE(parse_label_names("1 " + std::string(256, 'x') + " 1 1 1"));
  EXPECT_TRUE(parse_label_names(""));
}

TEST(LabelNames, ReadOrRejectChangedTexts) {
  std::mt19937 random(1);
  for (const std::string whole : {kSnap, kTable}) {
    for (int i = 0; i < 4000; ++i) {
      std::string text = whole;
      for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
        const std::size_t at = random() % text.size();
        if (random() % 3 == 0) {
          text.erase(at, 1 + random() % 5);
        } else {
          text[at] = random() % 2 == 0 ? static_cast<char>(random()) : "\"\n\t #-0"[random() % 7];
        }
        if (text.empty()) text = "1";
      }
      const auto labels = parse_label_names(text);
      if (!labels) {
        expect_contains(labels.error().text, "line ");
        continue;
      }
      for (const Label& label : *labels) {
        EXPECT_TRUE(check_member({.series = "f", .label = label})) << text;
      }
    }
  }
}

TEST(LabelNames, RejectOtherFiles) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& name, const std::string& text) -> std::string {
    if (!text.empty()) std::ofstream(folder.path() / name, std::ios::binary) << text;
    try {
      (void)read_label_names(folder.path() / name);
      return "";
    } catch (const VolumeFileError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(refusal("good.txt", kSnap), "");
  expect_contains(refusal("bad.txt", "x"), "bad.txt': line 1 is not a label");
  expect_contains(refusal("none.txt", ""), "cannot be opened");
  ASSERT_EQ(::mkfifo((folder.path() / "pipe.txt").c_str(), 0600), 0);
  expect_contains(refusal("pipe.txt", ""), "cannot be opened");
  expect_contains(refusal("large.txt", std::string((4 << 20) + 1, '\n')), "more than 4 MiB");
}

}  // namespace
}  // namespace multitetra

#include "server/dataset/objects/manifest.hpp"

#include <gtest/gtest.h>

#include <string>

namespace multitetra {
namespace {

Manifest some_manifest() {
  const std::vector<std::byte> bytes(100, std::byte{7});
  ObjectName full = name_of(bytes);
  full.size = kRunObjectBytes;
  ObjectName rest = full;
  rest.size = 5;
  return {.content_id = "0123456789abcdef",
          .sections = {{.name = "samples", .offset = kHeadBytes, .size = 1000},
                       {.name = "notes",
                        .required = false,
                        .offset = section_begin(kHeadBytes + 1000),
                        .size = 7,
                        .checksum = 0xFFFFFFFFFFFFFFFF}},
          .first = {.bytes = kRunObjectBytes + 5, .objects = {full, rest}},
          .later = {}};
}

TEST(Manifest, ComesBackAsItWas) {
  const Manifest manifest = some_manifest();
  const auto read = parse_manifest(manifest_text(manifest));
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(*read, manifest);
}

TEST(Manifest, OfSharedObjectsComesBackAndIsUnknownToVersionOne) {
  Manifest manifest = some_manifest();
  manifest.shares_objects = true;
  const std::string text = manifest_text(manifest);
  const auto read = parse_manifest(text);
  ASSERT_TRUE(read) << read.error().text;
  EXPECT_EQ(*read, manifest);
  EXPECT_NE(text.find("\"version\": 2"), std::string::npos);
}

TEST(Manifest, WithAnyByteChangedIsRefusedOrTheSame) {
  const Manifest manifest = some_manifest();
  const std::string text = manifest_text(manifest);
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const char change : {'\x01', '\x10', '\x20'}) {
      std::string changed = text;
      changed[i] = static_cast<char>(changed[i] ^ change);
      const auto read = parse_manifest(changed);
      if (read) {
        EXPECT_EQ(*read, manifest) << changed;  // Spaces between fields mean nothing.
      }
    }
    EXPECT_FALSE(parse_manifest(text.substr(0, i)) && i + 2 < text.size()) << i;
  }
}

TEST(Manifest, ThatIsNestedForNothingIsRefusedWithoutHarm) {
  EXPECT_FALSE(parse_manifest(R"({"format":"multitetra-objects","version":1,"x":)" +
                              std::string(5000000, '[')));
  std::string nested = R"({"format":"multitetra-objects","version":1,"file_version":2,"x":)";
  nested += std::string(1000000, '[') + std::string(1000000, ']') + "}";
  EXPECT_FALSE(parse_manifest(nested));
}

TEST(Manifest, OfAnotherVersionSaysSo) {
  std::string text = manifest_text(some_manifest());
  const std::string version = "\"version\": 1";
  text.replace(text.find(version), version.size(), "\"version\": 9");
  const auto read = parse_manifest(text);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kUnsupportedVersion);
}

TEST(ObjectName, IsWhatSha256sumPrints) {
  const ObjectName name = name_of(std::as_bytes(std::span("abc", 3)));
  EXPECT_EQ(name.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(name.key(), "objects/ba/" + name.hex());
  EXPECT_EQ(ObjectName::from(name.hex(), 3), name);
  EXPECT_FALSE(ObjectName::from(name.hex(), 0));
  EXPECT_FALSE(ObjectName::from(name.hex(), std::uint64_t{kMostObjectBytes} + 1));
  EXPECT_FALSE(ObjectName::from("BA" + name.hex().substr(2), 3));
  EXPECT_FALSE(ObjectName::from(name.hex().substr(2), 3));
}

}  // namespace
}  // namespace multitetra

#include "common/net/frame.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

std::string framed(const std::string& content) {
  return frame_header(static_cast<std::uint32_t>(content.size())) + content;
}

// Feeds the portions and extracts every frame as soon as it is complete.
std::vector<std::string> frames(const std::vector<std::string>& portions) {
  FrameReader reader(1000);
  std::vector<std::string> result;
  for (const std::string& portion : portions) {
    reader.feed(portion);
    while (true) {
      const auto frame = reader.next();
      EXPECT_TRUE(frame) << frame.error().text;
      if (!frame || !*frame) break;
      result.push_back(**frame);
    }
  }
  EXPECT_EQ(reader.buffered(), 0U);
  return result;
}

const std::vector<std::string> kContents = {"a", std::string(300, 'x'), std::string("\0\1\2", 3)};
const std::string kStream = framed(kContents[0]) + framed(kContents[1]) + framed(kContents[2]);

TEST(Frame, HasALittleEndianHeader) {
  EXPECT_EQ(frame_header(0x04030201), "\1\2\3\4");
  EXPECT_EQ(frame_header(0xFFFFFFFF), "\xFF\xFF\xFF\xFF");
}

TEST(FrameReader, ReadsTheSameFramesInOneFeed) { EXPECT_EQ(frames({kStream}), kContents); }

TEST(FrameReader, ReadsTheSameFramesByteByByte) {
  std::vector<std::string> bytes;
  for (const char byte : kStream) bytes.emplace_back(1, byte);
  EXPECT_EQ(frames(bytes), kContents);
}

TEST(FrameReader, ReadsTheSameFramesForEverySplitInThree) {
  for (std::size_t first = 0; first <= kStream.size(); first += 3) {
    for (std::size_t second = first; second <= kStream.size(); second += 7) {
      EXPECT_EQ(frames({kStream.substr(0, first), kStream.substr(first, second - first),
                        kStream.substr(second)}),
                kContents);
    }
  }
}

TEST(FrameReader, WaitsForACompleteFrame) {
  FrameReader reader(1000);
  const std::string frame = framed("hello");
  for (std::size_t bytes = 0; bytes + 1 < frame.size(); ++bytes) {
    reader.feed(frame.substr(bytes, 1));
    const auto next = reader.next();
    ASSERT_TRUE(next);
    EXPECT_FALSE(*next) << bytes + 1 << " bytes";
    EXPECT_EQ(reader.buffered(), bytes + 1);
  }
}

TEST(FrameReader, RejectsAFrameAboveTheLimitAndEverythingAfterIt) {
  FrameReader reader(1000);
  reader.feed(framed("ok") + frame_header(1001));
  EXPECT_EQ(reader.next().value(), std::optional<std::string>("ok"));
  for (int i = 0; i < 3; ++i) {
    const auto next = reader.next();
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().code, ErrorCode::kMessageTooLarge);
    EXPECT_NE(next.error().text.find("1001"), std::string::npos);
    EXPECT_NE(next.error().text.find("1000"), std::string::npos);
    reader.feed(framed("after"));
  }
}

TEST(FrameReader, AcceptsAFrameAtTheLimit) {
  FrameReader reader(1000);
  reader.feed(framed(std::string(1000, 'y')));
  EXPECT_EQ(reader.next().value(), std::optional<std::string>(std::string(1000, 'y')));
}

TEST(FrameReader, RejectsAFrameOfLengthZero) {
  FrameReader reader(1000);
  reader.feed(frame_header(0) + framed("after"));
  for (int i = 0; i < 2; ++i) {
    const auto next = reader.next();
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().code, ErrorCode::kMalformedFrame);
  }
}

TEST(FrameReader, BuffersOnlyUnreturnedBytes) {
  FrameReader reader(1000);
  const std::string frame = framed(std::string(900, 'z'));
  for (int i = 0; i < 10000; ++i) {
    reader.feed(frame);
    ASSERT_TRUE(reader.next()->has_value());
    ASSERT_EQ(reader.buffered(), 0U);
  }
}

TEST(FrameReader, RecognizesOtherProtocols) {
  for (const auto& [bytes, words] : std::vector<std::pair<std::string, std::string>>{
           {"HTTP/1.1 400 Bad Request", "ws://"},
           {"GET / HTTP/1.1", "received an HTTP request"},
           {"\x16\x03\x01\x02", "does not use TLS"},
           {"\x15\x03\x03\x02", "uses TLS"}}) {
    FrameReader reader(1000);
    reader.feed(bytes);
    const auto content = reader.next();
    ASSERT_FALSE(content) << bytes;
    EXPECT_EQ(content.error().code, ErrorCode::kMalformedFrame);
    EXPECT_NE(content.error().text.find(words), std::string::npos) << content.error().text;
  }
}

}  // namespace
}  // namespace multitetra

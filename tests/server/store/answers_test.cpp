// Parsing what stores answer, which may be anything.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/store/detail/bucket_listing.hpp"
#include "server/store/detail/content_range.hpp"
#include "server/store/detail/redirects.hpp"

namespace multitetra {
namespace {

TEST(ContentRange, ParsesTheRangeAndSize) {
  const auto range = ContentRange::from("bytes 10-29/1234");
  ASSERT_TRUE(range);
  EXPECT_TRUE(range->matches({.first = 10, .length = 20}));
  EXPECT_FALSE(range->matches({.first = 10, .length = 21})) << "there are more behind";
  EXPECT_FALSE(range->matches({.first = 11, .length = 19}));
  EXPECT_TRUE(ContentRange::from("bytes 10-29/30")->matches({.first = 10, .length = 100}));
  EXPECT_TRUE(
      ContentRange::from("bytes 10-29/30")->matches({.first = StoreRange::kFromEnd, .length = 20}));
  EXPECT_FALSE(
      ContentRange::from("bytes 10-29/*")->matches({.first = StoreRange::kFromEnd, .length = 20}));
}

TEST(ContentRange, RejectsInvalidRanges) {
  for (const char* const text :
       {"", "bytes", "bytes 10-9/20", "bytes 10-29/29", "bytes 10-29", "bytes -5/20",
        "bytes 10-29/30 ", "items 10-29/30", "bytes 99999999999999999999-1/2",
        // Lengths of 2^64 bytes overflow to 0.
        "bytes 0-18446744073709551615/0", "bytes 0-18446744073709551615/*"}) {
    EXPECT_FALSE(ContentRange::from(text)) << text;
  }
}

TEST(Redirects, NeverLeadFromHttpsToHttp) {
  for (const bool allow_other_hosts : {false, true}) {
    const auto refused =
        refused_redirect("https://a.example/x", "http://a.example/x", allow_other_hosts);
    ASSERT_TRUE(refused);
    EXPECT_NE(refused->problem.find("which does not use https"), std::string::npos)
        << refused->problem;
    EXPECT_TRUE(refused_redirect("http://a.example/x", "ftp://a.example/x", allow_other_hosts));
    EXPECT_TRUE(refused_redirect("http://a.example/x", "file:///etc/passwd", allow_other_hosts));
    EXPECT_FALSE(refused_redirect("http://a.example/x", "https://a.example/y", allow_other_hosts));
    EXPECT_FALSE(refused_redirect("https://a.example/x", "https://a.example/y", allow_other_hosts));
    EXPECT_EQ(refused_redirect("https://a.example/x", "https://b.example/x", allow_other_hosts)
                  .has_value(),
              !allow_other_hosts);
  }
}

TEST(Redirects, AreNamedWithoutPasswords) {
  const auto refused =
      refused_redirect("https://a.example/x", "https://me:secret@b.example/x", false);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->problem.find("secret"), std::string::npos) << refused->problem;
}

TEST(BucketListing, ReadsKeysAndTheContinuationToken) {
  const BucketListing listing = bucket_listing(
      "<ListBucketResult><IsTruncated>true</IsTruncated><NextContinuationToken>a&amp;b"
      "</NextContinuationToken><Contents><Key>x/&lt;1&gt;.mtd</Key></Contents>"
      "<Contents><Key>y</Key></Contents></ListBucketResult>");
  EXPECT_EQ(listing.keys, (std::vector<std::string>{"x/<1>.mtd", "y"}));
  EXPECT_EQ(listing.next, "a&b");
}

TEST(BucketListing, IgnoresTruncatedKeys) {
  EXPECT_TRUE(bucket_listing("<Key>whole.mtd</Key><Key>cut.mt").keys ==
              std::vector<std::string>{"whole.mtd"});
  EXPECT_EQ(bucket_listing("<IsTruncated>false</IsTruncated><NextContinuationToken>a"
                           "</NextContinuationToken>")
                .next,
            "");
}

}  // namespace
}  // namespace multitetra

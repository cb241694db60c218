#include "server/operations/admission_control.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

constexpr const char* kAddress = "192.0.2.7";

ClientContextPtr client_of(AdmissionControl& admission, const char* token = nullptr) {
  const ClientContextPtr client = admission.admit("tcp", kAddress, kAddress).client;
  if (token != nullptr) client->is_named(token, true);
  return client;
}

// Behind one address there may be a whole institute.
TEST(AdmissionControl, WhoAsksTooMuchLeavesTheirRateToOtherTokensOfTheirAddress) {
  AdmissionControl admission({.requests = {.per_second = 0.001, .burst = 2}});
  const ClientContextPtr greedy = client_of(admission, "eve");
  EXPECT_TRUE(greedy->may_ask());
  EXPECT_TRUE(client_of(admission, "eve")->may_ask());
  const auto refused = greedy->may_ask();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("with your token"), std::string::npos);
  EXPECT_GT(refused.error().retry_after, 0);
  EXPECT_TRUE(client_of(admission, "alice")->may_ask());
  EXPECT_TRUE(client_of(admission)->may_ask()) << "nor to those without one";
}

TEST(AdmissionControl, WithoutATokenAnAddressIsOne) {
  AdmissionControl admission({.requests = {.per_second = 0.001, .burst = 1}});
  EXPECT_TRUE(client_of(admission)->may_ask());
  const auto refused = client_of(admission)->may_ask();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("from your address"), std::string::npos);
  EXPECT_TRUE(client_of(admission, "alice")->may_ask());
}

}  // namespace
}  // namespace multitetra

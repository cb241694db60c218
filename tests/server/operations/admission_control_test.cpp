#include "server/operations/admission_control.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

constexpr const char* kAddress = "192.0.2.7";

ConnectionContextPtr client_of(AdmissionControl& admission, const char* token = nullptr) {
  const ConnectionContextPtr client = admission.admit("tcp", kAddress, kAddress).client;
  if (token != nullptr) client->set_identity(token, true);
  return client;
}

// One address may be that of a whole institute.
TEST(AdmissionControl, LimitsEachTokenOfOneAddressSeparately) {
  AdmissionControl admission({.requests = {.per_second = 0.001, .burst = 2}});
  const ConnectionContextPtr greedy = client_of(admission, "eve");
  EXPECT_TRUE(greedy->check_rate_limit());
  EXPECT_TRUE(client_of(admission, "eve")->check_rate_limit());
  const auto refused = greedy->check_rate_limit();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("with your token"), std::string::npos);
  EXPECT_GT(refused.error().retry_after, 0);
  EXPECT_TRUE(client_of(admission, "alice")->check_rate_limit());
  EXPECT_TRUE(client_of(admission)->check_rate_limit()) << "nor to those without one";
}

TEST(AdmissionControl, ClosesTheLongestIdleConnectionOfTheLargestShareForANewOne) {
  AdmissionControl admission({.connections = {.total = 5}});
  std::string ended;
  std::vector<ConnectionContextPtr> clients;
  const auto connect = [&](const char* address, const char* name, std::optional<int> rests_since) {
    auto admitted = admission.admit("tcp", address, name);
    using Clock = IdleConnection::Clock;
    admitted.client->set_evictable(
        {.since =
             [rests_since] {
               return rests_since
                          ? std::optional(Clock::time_point(std::chrono::seconds(*rests_since)))
                          : std::nullopt;
             },
         .end = [&ended, name](const Error&) { ended += name; }});
    clients.push_back(std::move(admitted.client));
    return !admitted.refusal;
  };
  EXPECT_TRUE(connect("192.0.2.1", "a", 10));
  EXPECT_TRUE(connect("192.0.2.2", "b", 40));
  EXPECT_TRUE(connect("192.0.2.2", "c", 30));
  EXPECT_TRUE(connect("192.0.2.2", "d", std::nullopt));
  EXPECT_TRUE(connect("192.0.2.3", "e", 20));
  EXPECT_TRUE(connect("192.0.2.4", "f", 60));
  EXPECT_EQ(ended, "c");
  EXPECT_FALSE(connect("192.0.2.2", "g", 70)) << "of the largest share itself";
  EXPECT_FALSE(connect("192.0.2.4", "h", 70)) << "two of one address, as all others have at most";
  EXPECT_EQ(ended, "c");
  EXPECT_EQ(admission.connections(), 5U);
}

class ExceededLimits : public ServiceObserver {
 public:
  void refused(const ClientFacts&, const char* limit) override { limits.emplace_back(limit); }
  std::vector<std::string> limits;
};

// Alerts of overload must not count the refusals of one address.
TEST(AdmissionControl, ReportsWhetherTheServerOrTheAddressHasTooManyConnections) {
  const auto exceeded = std::make_shared<ExceededLimits>();
  AdmissionControl admission({.connections = {.total = 2, .per_name = 1}, .observer = exceeded});
  std::vector<ConnectionContextPtr> clients;
  for (const char* address : {"192.0.2.1", "192.0.2.1", "192.0.2.2", "192.0.2.3"}) {
    clients.push_back(admission.admit("tcp", address, address).client);
  }
  EXPECT_EQ(exceeded->limits, (std::vector<std::string>{"connections_per_address", "connections"}));
}

TEST(AdmissionControl, CountsSubnetsOfAnIpv6NetworkAsOneShareWithFewConnections) {
  AdmissionControl admission(
      {.connections = {.per_name = 2}, .requests = {.per_second = 0.001, .burst = 2}});
  std::vector<ConnectionContextPtr> clients;
  int admitted = 0;
  int requested = 0;
  for (int i = 0; i < 64; ++i) {
    auto [client, refusal] =
        admission.admit("tcp", "2001:db8:1:" + std::to_string(i) + "00::7", "somebody");
    admitted += refusal ? 0 : 1;
    if (client && client->check_rate_limit()) ++requested;
    clients.push_back(std::move(client));
  }
  EXPECT_EQ(admitted, 8) << "a /48 has what four addresses have";
  EXPECT_EQ(requested, 8);
}

TEST(AdmissionControl, LimitsByAddressWithoutAToken) {
  AdmissionControl admission({.requests = {.per_second = 0.001, .burst = 1}});
  EXPECT_TRUE(client_of(admission)->check_rate_limit());
  const auto refused = client_of(admission)->check_rate_limit();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("from your address"), std::string::npos);
  EXPECT_TRUE(client_of(admission, "alice")->check_rate_limit());
}

}  // namespace
}  // namespace multitetra

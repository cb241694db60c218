// What the door for HTTP keeps up on a network: TLS, limits, whom they count for, and draining.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "tests/dataset/temporary_folder.hpp"
#include "tests/gateway/running_gateway.hpp"
#include "tests/gateway/tls_visit.hpp"
#include "tests/service/fake_steps.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::DoorCertificate;
using testing::FakeSteps;
using testing::HttpClient;
using testing::kAskWhetherAlive;
using testing::RunningGateway;
using testing::TlsVisit;
using testing::WebSocketClient;

CataloguePtr octahedra() { return catalogue_of(std::make_shared<FakeSteps>("octahedron")); }

unsigned status_of(HttpClient& client, std::string_view fields = {}) {
  return client.get("/livez", fields).result_int();
}

TEST(GuardedGateway, BeyondItsConnectionsTheFirstRequestIsAnsweredWith503) {
  RunningGateway server(octahedra(), {}, {.keeper = {.connections = {.total = 1}}});
  HttpClient first(server.http());
  EXPECT_EQ(status_of(first), 200U);
  HttpClient second(server.http());
  const auto answer = second.get("/v1/datasets");
  EXPECT_EQ(answer.result_int(), 503U);
  EXPECT_NE(answer.body().find("\"unavailable\""), std::string::npos) << answer.body();
  EXPECT_FALSE(answer.keep_alive());
  EXPECT_EQ(status_of(first), 200U);
}

TEST(GuardedGateway, BehindATrustedProxyLimitsCountForItsClients) {
  RunningGateway server(
      octahedra(), {},
      {.keeper = {.connections = {.total = 10, .per_name = 1}, .trusted_proxies = {"127.0.0.1"}}});
  HttpClient first(server.http());
  HttpClient second(server.http());
  HttpClient third(server.http());
  EXPECT_EQ(status_of(first, "X-Forwarded-For: 192.0.2.1\r\n"), 200U);
  EXPECT_EQ(status_of(second, "X-Forwarded-For: 192.0.2.2\r\n"), 200U);
  EXPECT_EQ(status_of(third, "X-Forwarded-For: 192.0.2.1\r\n"), 503U);
  EXPECT_EQ(status_of(first, "X-Forwarded-For: 192.0.2.1\r\n"), 200U) << "asks again";
}

TEST(GuardedGateway, NobodyElseSaysWhoItIs) {
  RunningGateway server(octahedra(), {}, {.keeper = {.connections = {.total = 10, .per_name = 1}}});
  HttpClient first(server.http());
  HttpClient second(server.http());
  EXPECT_EQ(status_of(first, "X-Forwarded-For: 192.0.2.1\r\n"), 200U);
  EXPECT_EQ(status_of(second, "X-Forwarded-For: 192.0.2.2\r\n"), 503U);
}

TEST(GuardedGateway, SpeaksTlsWithItsCertificate) {
  const DoorCertificate certificate;
  RunningGateway server(octahedra(), {}, {.keeper = {.tls = certificate.files()}});
  TlsVisit visit(server.http().port, certificate);
  visit.send(kAskWhetherAlive);
  EXPECT_TRUE(visit.read_to_end().starts_with("HTTP/1.1 200 "));
}

// The linger time would fail the test: it is not waited for when both have said goodbye.
TEST(GuardedGateway, HangsUpAtOnceWhenATlsClientHasSaidGoodbye) {
  const DoorCertificate certificate;
  RunningGateway server(octahedra(), {.linger = 1h}, {.keeper = {.tls = certificate.files()}});
  TlsVisit visit(server.http().port, certificate);
  visit.send(kAskWhetherAlive);
  (void)visit.read_to_end();
  EXPECT_TRUE(visit.parts_well());
}

TEST(GuardedGateway, IsNotReadyWhileItDrains) {
  std::atomic<int> running = 0;
  RunningGateway server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))));
  WebSocketClient busy(server.http());
  busy.send(Hello{});
  (void)busy.receive_a<Welcome>();
  busy.send(OpenStream{.request_id = 1, .dataset = "octahedron", .held = {}});
  while (running == 0) std::this_thread::sleep_for(1ms);
  HttpClient probe(server.http());
  EXPECT_EQ(probe.get("/readyz").result_int(), 200U);
  server.drain();
  unsigned status = 200;
  for (int i = 0; i < 5000 && status == 200; ++i) status = probe.get("/readyz").result_int();
  EXPECT_EQ(status, 503U);
  EXPECT_EQ(status_of(probe), 200U) << "It lives still.";
  EXPECT_EQ(probe.get("/v1/datasets/octahedron/isosurface?isovalue=1").result_int(), 503U);
}

}  // namespace
}  // namespace multitetra

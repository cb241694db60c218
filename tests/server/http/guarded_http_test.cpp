// Security of the HTTP listener: TLS, limits, the clients they apply to, and draining.
#include <atomic>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "tests/server/http/tls_request.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::catalogue_of;
using testing::expect_contains;
using testing::fake_catalogue;
using testing::FakeSteps;
using testing::HttpClient;
using testing::kAskWhetherAlive;
using testing::ListenerCertificate;
using testing::RunningHttpServer;
using testing::TlsRequest;
using testing::WebSocketClient;

unsigned status_of(HttpClient& client, std::string_view fields = {}) {
  return client.get("/v1/datasets", fields).result_int();
}

TEST(GuardedHttp, RejectsExcessConnectionsWith503) {
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.connections = {.total = 1}}});
  HttpClient first(server.http());
  EXPECT_EQ(status_of(first), 200U);
  HttpClient second(server.http());
  const auto answer = second.get("/v1/datasets");
  EXPECT_EQ(answer.result_int(), 503U);
  EXPECT_NE(answer.body().find("\"unavailable\""), std::string::npos) << answer.body();
  EXPECT_FALSE(answer.keep_alive());
  EXPECT_EQ(status_of(first), 200U);
}

TEST(GuardedHttp, AnswersProbesAboveTheLimitOfConnections) {
  RunningHttpServer server(fake_catalogue("octahedron"), {.base_path = "/volumes"},
                           {.admission = {.connections = {.total = 1}},
                            .metrics = std::make_shared<PrometheusMetrics>()});
  HttpClient first(server.http());
  EXPECT_EQ(status_of(first), 200U);
  for (const std::string target : {"/livez", "/readyz", "/metrics", "/volumes/metrics"}) {
    HttpClient probe(server.http());
    EXPECT_EQ(probe.get(target).result_int(), 200U) << target;
    EXPECT_EQ(probe.rest(), "") << target;
  }
  HttpClient other(server.http());
  EXPECT_EQ(other.get("/livez/v1/datasets").result_int(), 503U);
}

TEST(GuardedHttp, CountsRedirectsToTheBasePathAsSuch) {
  RunningHttpServer server(fake_catalogue("octahedron"), {.base_path = "/volumes"},
                           {.metrics = std::make_shared<PrometheusMetrics>()});
  HttpClient client(server.http());
  EXPECT_EQ(client.get("/volumes").result_int(), 308U);
  const std::string metrics = client.get("/metrics").body();
  EXPECT_NE(metrics.find("{kind=\"redirect\",status=\"308\"} 1\n"), std::string::npos) << metrics;
}

TEST(GuardedHttp, LimitsClientsOfATrustedProxy) {
  RunningHttpServer server(
      fake_catalogue("octahedron"), {},
      {.admission = {.connections = {.total = 10, .per_name = 1},
                     .trusted_proxies = *AddressRanges::parse({"127.0.0.0/8"})}});
  HttpClient first(server.http());
  HttpClient second(server.http());
  HttpClient third(server.http());
  EXPECT_EQ(status_of(first, "X-Forwarded-For: 192.0.2.1\r\n"), 200U);
  EXPECT_EQ(status_of(second, "X-Forwarded-For: 192.0.2.2\r\n"), 200U);
  EXPECT_EQ(status_of(third, "X-Forwarded-For: 192.0.2.1\r\n"), 503U);
  EXPECT_EQ(status_of(first, "X-Forwarded-For: 192.0.2.1\r\n"), 200U)
      << "the client requests again";
}

TEST(GuardedHttp, IgnoresForwardedForFromUntrustedPeers) {
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.connections = {.total = 10, .per_name = 1}}});
  HttpClient first(server.http());
  HttpClient second(server.http());
  EXPECT_EQ(status_of(first, "X-Forwarded-For: 192.0.2.1\r\n"), 200U);
  EXPECT_EQ(status_of(second, "X-Forwarded-For: 192.0.2.2\r\n"), 503U);
}

TEST(GuardedHttp, ServesTlsWithItsCertificate) {
  const ListenerCertificate certificate;
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.tls = certificate.files()}});
  TlsRequest context(server.http().port, certificate);
  context.send(kAskWhetherAlive);
  EXPECT_TRUE(context.read_to_end().starts_with("HTTP/1.1 200 "));
}

TEST(GuardedHttp, RejectsPlainHttpWithAnExplanation) {
  const ListenerCertificate certificate;
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.tls = certificate.files()}});
  HttpClient plain(server.http());
  const auto refused = plain.get("/livez");
  EXPECT_EQ(refused.result_int(), 400U);
  EXPECT_NE(refused.body().find("https://"), std::string::npos) << refused.body();
  EXPECT_EQ(plain.rest(), "");
}

// After close_notify from both sides the server does not linger, which would fail the test.
TEST(GuardedHttp, ClosesAfterCloseNotify) {
  const ListenerCertificate certificate;
  RunningHttpServer server(fake_catalogue("octahedron"), {.connection = {.linger = 1h}},
                           {.admission = {.tls = certificate.files()}});
  TlsRequest context(server.http().port, certificate);
  context.send(kAskWhetherAlive);
  (void)context.read_to_end();
  EXPECT_TRUE(context.parts_well());
}

constexpr std::string_view kAskForASurface =
    "GET /v1/datasets/octahedron/isosurface?isovalue=1 HTTP/1.1\r\nHost: x\r\n\r\n";

// Returns the metrics when one request has been counted with status 499, otherwise the last ones.
std::string metrics_with_a_client_that_left(const RunningHttpServer& server) {
  std::string metrics;
  for (int i = 0; i < 500; ++i) {
    metrics = HttpClient(server.http()).get("/metrics").body();
    if (metrics.find("status=\"499\"") != std::string::npos) break;
    std::this_thread::sleep_for(10ms);
  }
  return metrics;
}

// The next request's bytes hide the end of the connection.
TEST(GuardedHttp, StopsTheWorkOfAClientThatLeaves) {
  testing::Count running;
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))), {},
      {.metrics = std::make_shared<PrometheusMetrics>()});
  {
    HttpClient client(server.http());
    client.send(kAskForASurface);
    ASSERT_TRUE(running.reaches(1));
    client.send(kAskForASurface);
  }
  EXPECT_TRUE(running.reaches(0));
  expect_contains(metrics_with_a_client_that_left(server),
                  R"(http_answers_total{kind="isosurface",status="499"} 1)");
}

// TLS's close_notify hides it.
TEST(GuardedHttp, StopsTheWorkOfATlsClientThatLeaves) {
  testing::Count running;
  const ListenerCertificate certificate;
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))), {},
      {.admission = {.tls = certificate.files()}});
  TlsRequest client(server.http().port, certificate);
  client.send(kAskForASurface);
  ASSERT_TRUE(running.reaches(1));
  client.leave();
  EXPECT_TRUE(running.reaches(0));
}

TEST(GuardedHttp, IsNotReadyWhileDraining) {
  testing::Count running;
  RunningHttpServer server(
      catalogue_of(std::make_shared<FakeSteps>("octahedron", testing::endless(running))));
  WebSocketClient busy(server.http());
  busy.send(Hello{});
  (void)busy.receive_a<Welcome>();
  busy.send(OpenStream{.request_id = 1, .dataset = "octahedron", .cached_tile_digests = {}});
  ASSERT_TRUE(running.reaches(1));
  HttpClient probe(server.http());
  EXPECT_EQ(probe.get("/readyz").result_int(), 200U);
  server.drain();
  unsigned status = 200;
  for (int i = 0; i < 5000 && status == 200; ++i) status = probe.get("/readyz").result_int();
  EXPECT_EQ(status, 503U);
  EXPECT_EQ(probe.get("/livez").result_int(), 200U) << "It lives still.";
  EXPECT_EQ(probe.get("/v1/datasets/octahedron/isosurface?isovalue=1").result_int(), 503U);
}

}  // namespace
}  // namespace multitetra

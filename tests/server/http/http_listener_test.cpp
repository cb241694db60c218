// HTTP over real sockets: common properties of all responses, limits, and forbidden requests.
#include <chrono>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/json/json_report.hpp"
#include "server/http/host.hpp"
#include "server/operations/prometheus_metrics.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using namespace std::chrono_literals;
using testing::cache_of;
using testing::error_code_of;
using testing::fake_catalogue;
using testing::FakeSteps;
using testing::HttpClient;
using testing::RunningHttpServer;

TEST(HttpListener, AnswersManyRequestsOnOneConnection) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  for (int i = 0; i < 100; ++i) ASSERT_EQ(client.get("/livez").result_int(), 200U);
}

TEST(HttpListener, AnswersPipelinedRequestsInOrder) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  client.send(
      "GET /livez HTTP/1.1\r\nHost: x\r\n\r\nGET /nothing HTTP/1.1\r\nHost: x\r\n\r\n"
      "HEAD /livez HTTP/1.1\r\nHost: x\r\n\r\nGET /readyz HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(client.receive().result_int(), 200U);
  EXPECT_EQ(client.receive().result_int(), 404U);
  const auto head = client.receive(/*to_head=*/true);
  EXPECT_EQ(head.result_int(), 200U);
  EXPECT_EQ(head[http::field::content_length], "16");
  EXPECT_EQ(client.receive().body(), "{\"status\":\"ok\"}\n");
}

TEST(HttpListener, ClosesOnRequest) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient closing(server.http());
  EXPECT_EQ(closing.get("/livez", "Connection: close\r\n")[http::field::connection], "close");
  EXPECT_EQ(closing.rest(), "");
  HttpClient old(server.http());
  old.send("GET /livez HTTP/1.0\r\n\r\n");
  EXPECT_EQ(old.receive().result_int(), 200U);
  EXPECT_EQ(old.rest(), "");
}

TEST(HttpListener, ReturnsErrorsAsJsonWithTheRequestId) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  const auto response = client.get("/v1/datasets/none");
  EXPECT_EQ(response.result_int(), 404U);
  EXPECT_EQ(response[http::field::content_type], "application/json");
  const Json error = Json::parse(response.body()).at("error");
  EXPECT_EQ(error.at("code"), "unknown_dataset");
  EXPECT_NE(error.at("text").get<std::string>().find("none"), std::string::npos);
  EXPECT_EQ(error.at("request_id"), std::string(response["X-Request-Id"]));
  EXPECT_NE(response["X-Request-Id"], client.get("/livez")["X-Request-Id"]);
}

TEST(HttpListener, AcceptsThreeMethods) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  for (const auto* method : {"POST", "PUT", "DELETE", "PATCH", "TRACE", "BREW"}) {
    const auto response = client.request(method, "/v1/datasets");
    EXPECT_EQ(response.result_int(), 405U) << method;
    EXPECT_EQ(response[http::field::allow], "GET, HEAD, OPTIONS");
  }
  EXPECT_EQ(client.request("OPTIONS", "/v1/datasets").result_int(), 204U);
}

TEST(HttpListener, ClosesConnectionsAfterUnparsableRequests) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  for (const auto& [bytes, status] : std::initializer_list<std::pair<std::string, unsigned>>{
           {"no request\r\n\r\n", 400},
           {"GET /" + std::string(20'000, 'a'), 431},
           {"POST /livez HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc", 413},
           {"GET /livez HTTP/1.1\r\nContent-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n",
            400}}) {
    HttpClient client(server.http());
    client.send(bytes);
    const auto response = client.receive();
    EXPECT_EQ(response.result_int(), status);
    EXPECT_EQ(response[http::field::connection], "close");
    EXPECT_EQ(error_code_of(response), "malformed_message");
    EXPECT_EQ(client.rest(), "");
  }
}

TEST(HttpListener, LimitsTheTimeForAHeader) {
  RunningHttpServer server(fake_catalogue("octahedron"),
                           {.connection = {.handshake_timeout = 80ms}});
  HttpClient client(server.http());
  client.send("GET /livez HTTP/1.1\r\nHost:");
  EXPECT_EQ(client.rest(), "");
}

// The timeout after a request is longer than the one before the first request.
TEST(HttpListener, LimitsTheTimeForTheFirstRequest) {
  RunningHttpServer server(fake_catalogue("octahedron"),
                           {.connection = {.handshake_timeout = 80ms}, .keep_alive_timeout = 1h});
  HttpClient silent(server.http());
  EXPECT_EQ(silent.rest(), "");
}

TEST(HttpListener, AcceptsEveryFormOfTarget) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  EXPECT_EQ(client.get("http://localhost/v1/datasets/octahedron").result_int(), 200U);
  const auto all = client.request("OPTIONS", "*");
  EXPECT_EQ(all.result_int(), 204U);
  EXPECT_EQ(all[http::field::allow], "GET, HEAD, OPTIONS");
  EXPECT_EQ(client.get("*").result_int(), 400U);
}

TEST(HttpListener, LimitsTheTimeBetweenRequests) {
  RunningHttpServer server(fake_catalogue("octahedron"), {.keep_alive_timeout = 80ms});
  HttpClient client(server.http());
  EXPECT_EQ(client.get("/livez").result_int(), 200U);
  EXPECT_EQ(client.rest(), "");
}

TEST(HttpListener, LimitsConnections) {
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.connections = {.total = 1}}});
  HttpClient first(server.http());
  EXPECT_EQ(first.get("/livez").result_int(), 200U);
  HttpClient second(server.http());
  EXPECT_EQ(second.get("/v1/datasets").result_int(), 503U);
  EXPECT_EQ(second.rest(), "");
  EXPECT_EQ(first.get("/livez").result_int(), 200U);
}

TEST(HttpListener, ReportsReadiness) {
  std::atomic<bool> ready = true;
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.metrics = std::make_shared<PrometheusMetrics>()}, {},
                           [&] { return ready.load(); });
  HttpClient client(server.http());
  EXPECT_EQ(client.get("/readyz").result_int(), 200U);
  ready = false;
  const auto response = client.get("/readyz");
  EXPECT_EQ(response.result_int(), 503U);
  EXPECT_EQ(response[http::field::retry_after], "1");
  EXPECT_EQ(client.get("/livez").result_int(), 200U);
  const std::string metrics = client.get("/metrics").body();
  EXPECT_NE(metrics.find("multitetra_http_answers_total{kind=\"readyz\",status=\"503\"} 1\n"),
            std::string::npos)
      << metrics;
}

// A list takes two messages of a conversation and a mesh three; each counts as one request.
TEST(HttpListener, LimitsTheRequestsOfAnAddress) {
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.requests = {.per_second = 0.001, .burst = 4}},
                            .metrics = std::make_shared<PrometheusMetrics>()});
  HttpClient client(server.http());
  const std::string mesh = "/v1/datasets/octahedron/isosurface?isovalue=0.5&error=";
  for (const std::string& target : {std::string("/v1/datasets"), mesh + "1", mesh + "2",
                                    std::string("/v1/datasets/octahedron")}) {
    EXPECT_EQ(client.get(target).result_int(), 200U) << target;
  }
  for (const std::string& target : {mesh + "3", std::string("/v1/datasets")}) {
    const auto refused = client.get(target);
    EXPECT_EQ(refused.result_int(), 429U) << target;
    EXPECT_EQ(refused[http::field::retry_after], "1000");
  }
  EXPECT_EQ(client.get("/livez").result_int(), 200U);
  const std::string counted = "errors_total{code=\"limit_exceeded\",transport=\"http\"} 2";
  const std::string metrics = client.get("/metrics").body();
  EXPECT_NE(metrics.find(counted), std::string::npos) << metrics;
}

TEST(HttpListener, LimitsEachTokenOfOneAddressSeparately) {
  const TemporaryFolder folder;
  const testing::TokensFile tokens(folder.path(), {{"alice", "one", "*"}, {"bob", "two", "*"}});
  RunningHttpServer server(
      fake_catalogue("octahedron"), {},
      {.admission = {.tokens = tokens.path(), .requests = {.per_second = 0.001, .burst = 2}}});
  const auto status_of = [&](const std::string& token) {
    HttpClient client(server.http());
    return client.get("/v1/datasets", "Authorization: Bearer " + token + "\r\n").result_int();
  };
  EXPECT_EQ(status_of("one"), 200U);
  EXPECT_EQ(status_of("one"), 200U);
  EXPECT_EQ(status_of("one"), 429U);
  EXPECT_EQ(status_of("two"), 200U) << "another token";
  EXPECT_EQ(status_of("none"), 401U);
  EXPECT_EQ(status_of("nobody"), 401U);
  EXPECT_EQ(status_of("guess"), 429U) << "unknown tokens count for their address";
  EXPECT_EQ(status_of("two"), 200U);
}

TEST(HttpListener, ChargesUnknownTokensToNoEarlierToken) {
  const TemporaryFolder folder;
  const testing::TokensFile tokens(folder.path(), {{"alice", "one", "*"}});
  RunningHttpServer server(
      fake_catalogue("octahedron"), {},
      {.admission = {.tokens = tokens.path(), .requests = {.per_second = 0.001, .burst = 2}}});
  HttpClient client(server.http());
  const auto status_of = [&](const std::string& token) {
    return client.get("/v1/datasets", "Authorization: Bearer " + token + "\r\n").result_int();
  };
  EXPECT_EQ(status_of("one"), 200U);
  EXPECT_EQ(status_of("one"), 200U);
  EXPECT_EQ(status_of("guess"), 401U);
  EXPECT_EQ(status_of("one"), 429U);
}

TEST(HttpListener, AllowsListedOriginsToReadAnswers) {
  RunningHttpServer server(fake_catalogue("octahedron"),
                           {.allowed_origins = {"https://a.example"}});
  HttpClient client(server.http());
  const auto allowed = client.get("/v1/datasets", "Origin: https://a.example\r\n");
  EXPECT_EQ(allowed["Access-Control-Allow-Origin"], "https://a.example");
  EXPECT_EQ(allowed[http::field::vary], "Origin");
  for (const std::string field : {"Multitetra-Components-Written", "Multitetra-Width"}) {
    EXPECT_NE(allowed["Access-Control-Expose-Headers"].find(field), std::string::npos) << field;
  }
  const auto other = client.get("/v1/datasets", "Origin: https://b.example\r\n");
  EXPECT_EQ(other.count("Access-Control-Allow-Origin"), 0U);
  EXPECT_EQ(other[http::field::vary], "Origin");
  const auto preflight = client.request("OPTIONS", "/v1/datasets/a/isosurface",
                                        "Origin: https://a.example\r\n"
                                        "Access-Control-Request-Method: GET\r\n");
  EXPECT_EQ(preflight.result_int(), 204U);
  EXPECT_EQ(preflight["Access-Control-Allow-Methods"], "GET, HEAD, OPTIONS");
}

TEST(HttpListener, RejectsOtherHostNames) {
  RunningHttpServer server(fake_catalogue("octahedron"), {.allowed_hosts = {"volumes.example"}});
  const auto status_as = [&](const std::string& host) {
    HttpClient client(server.http());
    client.send("GET /v1/datasets HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    return client.receive().result_int();
  };
  for (const char* own : {"volumes.example", "Volumes.Example:7480", "127.0.0.1:7480", "[::1]:7480",
                          "localhost:7480"}) {
    EXPECT_EQ(status_as(own), 200U) << own;
  }
  for (const char* other :
       {"evil.example", "volumes.example.evil.example", "127.0.0.1.evil.example"}) {
    EXPECT_EQ(status_as(other), 421U) << other;
  }
  // WebSockets are rejected too, although the page's origin is that host.
  HttpClient client(server.http());
  client.send("GET /v1/stream HTTP/1.1\r\nHost: evil.example\r\nOrigin: http://evil.example\r\n" +
              std::string(testing::kUpgradeFields) + "\r\n");
  EXPECT_EQ(client.receive().result_int(), 421U);
}

TEST(Hosts, AllowAddressesLocalhostAndConfiguredNames) {
  const std::vector<std::string> allowed = {".site.example", "one.example"};
  for (const char* host : {"site.example", "a.site.example:80", "a.b.SITE.example.", "one.example",
                           "", "10.1.2.3:99", "[fe80::1]", "app.localhost"}) {
    EXPECT_TRUE(is_allowed_host(host, allowed)) << host;
  }
  for (const char* host : {"a.one.example", "othersite.example", "one.example.org", "[",
                           "[evil.example]", "1.2.3.4.example"}) {
    EXPECT_FALSE(is_allowed_host(host, allowed)) << host;
  }
  EXPECT_TRUE(is_allowed_host("anything.example", {"*"}));
  for (const char* pattern : {"*", "example.org", ".example.org", "my_host-1"}) {
    EXPECT_TRUE(is_host_pattern(pattern)) << pattern;
  }
  for (const char* pattern :
       {"", ".", "https://example.org", "example.org:80", "*.example.org", "a/b"}) {
    EXPECT_FALSE(is_host_pattern(pattern)) << pattern;
  }
}

TEST(HttpListener, DescribesDatasetsLikeTheInfoCommand) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  const auto list = client.get("/v1/datasets");
  const Json datasets = Json::parse(list.body()).at("datasets");
  ASSERT_EQ(datasets.size(), 1U);
  EXPECT_EQ(datasets[0].at("name"), "octahedron");
  EXPECT_FALSE(datasets[0].contains("histogram"));
  const auto one = client.get("/v1/datasets/octahedron");
  EXPECT_EQ(one.body(), text_of(json_of(FakeSteps("octahedron").info())));
  const std::string tag(one[http::field::etag]);
  const auto again = client.get("/v1/datasets/octahedron", "If-None-Match: " + tag + "\r\n");
  EXPECT_EQ(again.result_int(), 304U);
  EXPECT_EQ(again[http::field::etag], tag);
  EXPECT_EQ(client.get("/v1/datasets/%6Fctahedron").result_int(), 200U);
}

TEST(HttpListener, ServesCachedTilesAsImmutable) {
  const auto tile = testing::fine_tiles().front();
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.service = {.cache = cache_of(tile, "octahedron")}});
  HttpClient client(server.http());
  const std::string path = "/v1/tiles/" + tile.summary.digest.hex();
  const auto whole = client.get(path);
  EXPECT_EQ(whole.result_int(), 200U);
  EXPECT_EQ(whole.body(), *tile.payload);
  EXPECT_NE(whole[http::field::cache_control].find("immutable"), std::string::npos);
  const auto part = client.get(path, "Range: bytes=2-5\r\n");
  EXPECT_EQ(part.result_int(), 206U);
  EXPECT_EQ(part.body(), tile.payload->substr(2, 4));
  EXPECT_EQ(part[http::field::content_range], "bytes 2-5/" + std::to_string(tile.payload->size()));
  const auto beyond = client.get(path, "Range: bytes=99999999-\r\n");
  EXPECT_EQ(beyond.result_int(), 416U);
  const auto known =
      client.get(path, "If-None-Match: " + std::string(whole[http::field::etag]) + "\r\n");
  EXPECT_EQ(known.result_int(), 304U);
  EXPECT_EQ(client.get("/v1/tiles/" + ContentDigest{}.hex()).result_int(), 404U);
  EXPECT_EQ(client.get("/v1/tiles/xyz").result_int(), 400U);
}

TEST(HttpListener, RequiresAValidToken) {
  const TemporaryFolder folder;
  const testing::TokensFile tokens(folder.path(), {{"alice", "good", "octahedron"}});
  const auto tile = testing::fine_tiles().front();
  RunningHttpServer server(
      fake_catalogue("octahedron"), {},
      {.admission = {.tokens = tokens.path()}, .service = {.cache = cache_of(tile, "octahedron")}});
  HttpClient client(server.http());
  for (const std::string& path :
       {"/v1/tiles/" + tile.summary.digest.hex(), std::string("/v1/datasets"),
        std::string("/v1/datasets/octahedron"),
        std::string("/v1/datasets/octahedron/isosurface?isovalue=1")}) {
    const auto refusal = client.get(path);
    EXPECT_EQ(refusal.result_int(), 401U) << path;
    EXPECT_EQ(refusal[http::field::www_authenticate], "Bearer");
    EXPECT_EQ(error_code_of(refusal), "unauthenticated");
    EXPECT_EQ(client.get(path, "Authorization: Bearer bad\r\n").result_int(), 401U) << path;
    EXPECT_EQ(client.get(path, "Authorization: Basic good\r\n").result_int(), 401U) << path;
    const auto response = client.get(path, "Authorization: bearer good\r\n");
    EXPECT_EQ(response.result_int(), 200U) << path;
    EXPECT_EQ(response[http::field::cache_control].find("public"), boost::beast::string_view::npos);
  }
  EXPECT_EQ(client.get("/livez").result_int(), 200U);
}

TEST(HttpListener, SendsTilesOnlyOfVisibleDatasets) {
  const TemporaryFolder folder;
  const testing::TokensFile tokens(
      folder.path(), {{"alice", "good", "octahedron"}, {"bob", "other", "another-*"}});
  const auto tile = testing::fine_tiles().front();
  RunningHttpServer server(
      fake_catalogue("octahedron"), {},
      {.admission = {.tokens = tokens.path()}, .service = {.cache = cache_of(tile, "octahedron")}});
  HttpClient client(server.http());
  const std::string path = "/v1/tiles/" + tile.summary.digest.hex();
  EXPECT_EQ(client.get(path, "Authorization: Bearer good\r\n").result_int(), 200U);
  EXPECT_EQ(client.get(path, "Authorization: Bearer other\r\n").result_int(), 404U);
}

TEST(HttpListener, SendsSampleShellsOnlyToClientsThatMaySeeSamples) {
  const TemporaryFolder folder;
  const testing::TokensFile tokens(
      folder.path(), {{"alice", "samples", "*"}, {"bob", "surfaces", "* only=surfaces"}});
  const auto tile = testing::fine_tiles().front();  // The payload is never decoded here.
  const auto shell = cache_of(tile, "octahedron", kShellAppearance);
  RunningHttpServer server(fake_catalogue("octahedron"), {},
                           {.admission = {.tokens = tokens.path()}, .service = {.cache = shell}});
  RunningHttpServer for_surfaces(
      fake_catalogue("octahedron"), {},
      {.service = {.requests = {.surfaces_only = true}, .cache = shell}});
  HttpClient client(server.http());
  const std::string path = "/v1/tiles/" + tile.summary.digest.hex();
  const auto hers = client.get(path, "Authorization: Bearer samples\r\n");
  EXPECT_EQ(hers.result_int(), 200U);
  EXPECT_EQ(hers.body(), *tile.payload);
  EXPECT_EQ(hers[http::field::content_type], "application/octet-stream");
  EXPECT_EQ(client.get(path, "Authorization: Bearer surfaces\r\n").result_int(), 404U);
  EXPECT_EQ(HttpClient(for_surfaces.http()).get(path).result_int(), 404U);
}

// ---- the viewer's files

class ViewerTest : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    const auto file = folder_.path() / "viewer" / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  TemporaryFolder folder_;
};

TEST_F(ViewerTest, AllowsConnectionsOnlyToItsHost) {
  write("index.html", "<p>viewer");
  RunningHttpServer server(fake_catalogue("octahedron"), {}, {},
                           {.viewer = std::make_shared<ViewerFiles>(folder_.path() / "viewer")});
  const auto page = HttpClient(server.http()).get("/");
  std::map<std::string, std::string> policy;
  std::istringstream directives{std::string(page["Content-Security-Policy"])};
  for (std::string one; std::getline(directives >> std::ws, one, ';');) {
    const std::size_t end = one.find(' ');
    policy[one.substr(0, end)] = one.substr(end + 1);
  }
  EXPECT_EQ(policy["default-src"], "'self'");
  EXPECT_EQ(policy["connect-src"], "'self'");
  EXPECT_EQ(policy["worker-src"], "'self'");
  EXPECT_EQ(policy["form-action"], "'none'");
  EXPECT_EQ(policy["base-uri"], "'none'");
  EXPECT_EQ(policy["script-src"].find("unsafe-inline"), std::string::npos);
  EXPECT_EQ(policy["frame-ancestors"], "'self'");
}

TEST_F(ViewerTest, AllowsFramesOnlyFromListedOrigins) {
  write("index.html", "<p>viewer");
  RunningHttpServer server(fake_catalogue("octahedron"),
                           {.allowed_origins = {"https://journal.example", "*", "http://a:8888"}},
                           {},
                           {.viewer = std::make_shared<ViewerFiles>(folder_.path() / "viewer")});
  const std::string policy(HttpClient(server.http()).get("/")["Content-Security-Policy"]);
  EXPECT_TRUE(policy.ends_with("; frame-ancestors 'self' https://journal.example http://a:8888"))
      << policy;
}

TEST_F(ViewerTest, ServesOnlyOneFolder) {
  write("index.html", "<p>viewer");
  write("assets/index-1a2b.js", "let x = 1;");
  write("assets/index-1a2b.js.gz", "zipped");
  write("../secret.txt", "secret");
  std::filesystem::create_symlink(folder_.path() / "secret.txt",
                                  folder_.path() / "viewer" / "link.txt");
  std::filesystem::create_directory_symlink(folder_.path(), folder_.path() / "viewer" / "up");
  RunningHttpServer server(fake_catalogue("octahedron"), {}, {},
                           {.viewer = std::make_shared<ViewerFiles>(folder_.path() / "viewer")});
  HttpClient client(server.http());
  const auto page = client.get("/");
  EXPECT_EQ(page.body(), "<p>viewer");
  EXPECT_EQ(page[http::field::content_type], "text/html; charset=utf-8");
  EXPECT_EQ(page[http::field::cache_control], "no-cache");
  const auto plain = client.get("/assets/index-1a2b.js");
  EXPECT_EQ(plain.body(), "let x = 1;");
  EXPECT_EQ(plain[http::field::content_type], "text/javascript; charset=utf-8");
  EXPECT_NE(plain[http::field::cache_control].find("immutable"), boost::beast::string_view::npos);
  const auto zipped = client.get("/assets/index-1a2b.js", "Accept-Encoding: br, gzip\r\n");
  EXPECT_EQ(zipped.body(), "zipped");
  EXPECT_EQ(zipped[http::field::content_encoding], "gzip");
  EXPECT_NE(zipped[http::field::etag], plain[http::field::etag]);
  for (const auto* path :
       {"/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt", "/assets/../../secret.txt",
        "/link.txt", "/up/secret.txt", "//etc/passwd", "/secret.txt", "/assets/", "/assets",
        "/index.html%00.js", "/.%00./secret.txt", "/\\..\\secret.txt"}) {
    EXPECT_EQ(client.get(path).result_int(), 404U) << path;
  }
}

TEST_F(ViewerTest, ShowsAPageIfNotInstalled) {
  RunningHttpServer server(fake_catalogue("octahedron"));
  HttpClient client(server.http());
  EXPECT_NE(client.get("/").body().find("not installed"), std::string::npos);
  EXPECT_EQ(client.get("/index.js").result_int(), 404U);
}

}  // namespace
}  // namespace multitetra

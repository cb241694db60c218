// A server of ten thousand datasets: lists come in pages, and no task of the network's thread grows
// with their number.
#include <gtest/gtest.h>

#include "client/library/client.hpp"
#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/running_server.hpp"

namespace multitetra {
namespace {

using testing::FakeSteps;
using testing::HttpClient;
using testing::RunningHttpServer;

constexpr std::size_t kMany = 10'000;

std::string name_of(std::size_t i) {
  return (i % 2 == 0 ? "study.label" : "hidden.label") + std::to_string(i);
}

CataloguePtr many_datasets() {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  for (std::size_t i = 0; i < kMany; ++i) catalogue->add(std::make_shared<FakeSteps>(name_of(i)));
  return catalogue;
}

std::vector<std::string> names_of(const std::vector<DatasetInfo>& datasets) {
  std::vector<std::string> names;
  for (const DatasetInfo& info : datasets) names.push_back(info.name);
  return names;
}

std::vector<std::string> listed_over_http(HttpClient& client) {
  std::vector<std::string> names;
  std::string target = "/v1/datasets";
  for (int pages = 0; pages < 100; ++pages) {
    const auto response = client.get(target);
    EXPECT_EQ(response.result_int(), 200U);
    const auto list = parse_json(response.body());
    for (const auto& dataset : list.at("datasets")) {
      names.push_back(dataset.at("name").get<std::string>());
      EXPECT_FALSE(dataset.contains("histogram"));
    }
    if (list.at("next").is_null()) return names;
    target = "/v1/datasets?after=" + list.at("next").get<std::string>();
  }
  ADD_FAILURE() << "the pages do not end";
  return names;
}

double metric(HttpClient& client, const std::string& name) {
  const std::string text = client.get("/metrics").body();
  const std::size_t at = text.find("\n" + name + " ");
  EXPECT_NE(at, std::string::npos) << name;
  const std::size_t from = at + name.size() + 2;
  return parse_finite(text.substr(from, text.find('\n', from) - from)).value_or(-1);
}

TEST(ManyDatasets, AreListedAndRefusedWithoutLongTasks) {
  const CataloguePtr catalogue = many_datasets();
  std::vector<std::string> all;
  for (const auto& [name, entry] : catalogue->entries()) all.push_back(name);
  RunningHttpServer server(catalogue, {}, {.metrics = std::make_shared<PrometheusMetrics>()});
  auto client = Client::connect(server.tcp(), {});
  ASSERT_TRUE(client);
  HttpClient http(server.http());
  for (int i = 0; i < 3; ++i) {
    const auto datasets = client->list_datasets();
    ASSERT_TRUE(datasets) << datasets.error().error.text;
    EXPECT_EQ(names_of(*datasets), all);
    EXPECT_EQ(listed_over_http(http), all);
  }
  const auto known = http.get("/v1/datasets");
  EXPECT_EQ(http.get("/v1/datasets", "If-None-Match: " + std::string(known["ETag"]) + "\r\n")
                .result_int(),
            304U);
  for (const std::string& wrong : {std::string("study.label402x"), std::string(255, 's')}) {
    EXPECT_EQ(http.get("/v1/datasets/" + wrong).result_int(), 404U);
  }
  EXPECT_NE(http.get("/v1/datasets/study.label401").body().find("Did you mean"), std::string::npos);
  // An unoptimized or instrumented program takes several times as long; describing all datasets at
  // once takes a hundred times as long.
  EXPECT_LT(metric(http, "multitetra_network_longest_task_seconds"), 0.015);
  EXPECT_GT(metric(http, "multitetra_network_longest_task_seconds"), 0);
}

TEST(ManyDatasets, ClientsThatKnowNoPagesGetTheFirst) {
  RunningHttpServer server(many_datasets());
  auto socket = MessageSocket::connect(server.tcp(), std::chrono::seconds(30));
  ASSERT_TRUE(socket);
  ASSERT_TRUE(socket->send(Hello{}));
  (void)testing::receive<Welcome>(*socket);
  ASSERT_TRUE(socket->send(ListDatasets{.request_id = 1}));
  EXPECT_EQ(testing::receive<DatasetList>(*socket).datasets.size(), kMaxListedDatasets);
}

TEST(ManyDatasets, PagesNameOnlyWhatAClientMaySee) {
  auto access = std::make_shared<AccessList>();
  access->add({.digest = digest_of_token("t"), .rights = AccessRights("alice", {"study.*"})});
  const auto client_access = ClientAccess::of("t", access, many_datasets());
  ASSERT_TRUE(client_access);
  std::size_t visible = 0;
  std::string after;
  do {
    const DatasetPage page = client_access->list(after, {.datasets = 7});
    for (const auto* const entry : page.datasets) {
      EXPECT_TRUE(entry->source->info().name.starts_with("study."));
    }
    EXPECT_FALSE(page.next.starts_with("hidden")) << page.next;
    visible += page.datasets.size();
    after = page.next;
  } while (!after.empty());
  EXPECT_EQ(visible, kMany / 2);
}

}  // namespace
}  // namespace multitetra

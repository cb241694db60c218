// Fetching over a network that cuts connections, at every possible place.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <tuple>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/library/client.hpp"
#include "tests/client/cutting_proxy.hpp"
#include "tests/client/transport_listener.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"
#include "tests/support/sweep.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/waiting.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using testing::Cut;
using testing::CuttingProxy;
using testing::RunningServer;
using testing::TransportListener;

constexpr int kSide = 72;
const IsosurfaceRequest kRequest = {.isovalue = 0.1, .error = 0.25};

CataloguePtr gyroid(double amplitude = 0.4) {
  // Many cut connections request the same steps; the cache makes them only once.
  return testing::catalogue_with(
      {make_dataset(testing::fields::gyroid(kSide, amplitude, 7), "gyroid")},
      std::make_shared<SurfaceCache>(std::size_t{64} << 20));
}

// One dataset for all tests, so that its steps are made only once.
const CataloguePtr& shared_gyroid() {
  static const CataloguePtr catalogue = gyroid();
  return catalogue;
}

RetryOptions at_once(int most) {
  return {.most = most,
          .first_wait = std::chrono::milliseconds(1),
          .longest_wait = std::chrono::milliseconds(2)};
}

// Fetches like the program: connects, lists and fetches, retrying whatever was lost.
ClientResult<std::vector<FetchedStep>> fetch_from(const Endpoint& server, int retries,
                                                  const Trust& trust = {},
                                                  MeshUse use = MeshUse::kKeep) {
  Retries again(at_once(retries));
  for (;;) {
    auto client = Client::connect(server, {.timeout = std::chrono::seconds(30), .trust = trust});
    auto datasets = client ? client->list_datasets() : tl::unexpected(client.error());
    if (!datasets && again.wait_after(datasets.error().error)) continue;
    if (!datasets) return tl::unexpected(datasets.error());
    std::vector<FetchedStep> steps;
    const auto fetched = client->fetch(
        datasets->front(),
        {.dataset = "gyroid", .request = kRequest, .cached_tile_digests = {}, .use = use},
        [&steps](const FetchedStep& step) { steps.push_back(step); },
        {.retries = at_once(retries)});
    if (!fetched) return tl::unexpected(fetched.error());
    return steps;
  }
}

bool are_distinct(const std::vector<ContentDigest>& tiles) {
  return std::set<ContentDigest>(tiles.begin(), tiles.end()).size() == tiles.size();
}

// A client's route to a proxy: directly, or through a listener of another transport.
class Way {
 public:
  Way(Transport transport, const Endpoint& server) : endpoint_(server) {
    if (transport == Transport::kTcp) return;
    listener_.emplace(transport, server);
    endpoint_ = listener_->endpoint();
  }
  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }
  [[nodiscard]] Trust trust() const { return listener_ ? listener_->trust() : Trust{}; }

  [[nodiscard]] ClientResult<std::vector<FetchedStep>> fetch(int retries) const {
    return fetch_from(endpoint_, retries, trust());
  }

 private:
  Endpoint endpoint_;
  std::optional<TransportListener> listener_;
};

class Resume : public ::testing::TestWithParam<Transport> {
 protected:
  // Records an undisturbed conversation.
  void SetUp() override {
    const CuttingProxy proxy({server_.endpoint()}, [](int) { return Cut{}; });
    const auto steps = fetch_from(proxy.endpoint(), 0);
    ASSERT_TRUE(steps) << steps.error().error.text;
    for (const FetchedStep& step : *steps) digests_.push_back(step.step->end.digest);
    tiles_ = proxy.tiles().size();
    final_tiles_ = steps->back().step->begin.tiles.size();
    messages_ = static_cast<std::size_t>(proxy.messages());
    ASSERT_GE(digests_.size(), 2U);
    ASSERT_GE(tiles_, 8U);
    ASSERT_EQ(messages_, 2 + 2 * digests_.size() + tiles_ + 1);
  }

  // Over TCP cuts are tested at every place; other transports only relay them, so fewer suffice.
  [[nodiscard]] static std::size_t stride(std::size_t over_tcp) {
    return GetParam() == Transport::kTcp ? over_tcp : testing::sweep(8U, 4U) * over_tcp + 1;
  }

  void expect_the_same(const ClientResult<std::vector<FetchedStep>>& steps,
                       const CuttingProxy& proxy) const {
    ASSERT_TRUE(steps) << steps.error().error.text;
    std::vector<ContentDigest> given;
    for (const FetchedStep& step : *steps) given.push_back(step.step->end.digest);
    EXPECT_EQ(given, digests_) << "each step is given once";
    EXPECT_TRUE(are_distinct(proxy.tiles())) << "a tile was sent twice";
    EXPECT_EQ(proxy.tiles().size(), tiles_);
  }

  RunningServer server_{shared_gyroid()};
  std::vector<ContentDigest> digests_;  // The digests of the steps.
  std::size_t tiles_ = 0;
  std::size_t final_tiles_ = 0;
  std::size_t messages_ = 0;
};

TEST_P(Resume, ContinuesAfterACutAtAnyMessage) {
  for (std::size_t passed = 0; passed < messages_; passed += stride(testing::sweep(2U, 1U))) {
    SCOPED_TRACE(::testing::Message() << "cut after " << passed << " of " << messages_);
    const CuttingProxy proxy({server_.endpoint()},
                             [&](int i) { return i == 0 ? Cut{.messages = passed} : Cut{}; });
    expect_the_same(Way(GetParam(), proxy.endpoint()).fetch(1), proxy);
    EXPECT_EQ(proxy.connections(), 2);
  }
}

TEST_P(Resume, ContinuesAfterACutInsideAFrame) {
  for (std::size_t passed = 0; passed < messages_; passed += stride(testing::sweep(7U, 3U))) {
    for (const std::size_t bytes : {1U, 4U, 5U, 1'000'000U}) {
      SCOPED_TRACE(::testing::Message() << bytes << " bytes behind " << passed << " messages");
      const CuttingProxy proxy({server_.endpoint()}, [&](int i) {
        return i == 0 ? Cut{.messages = passed, .bytes_of_next = bytes} : Cut{};
      });
      expect_the_same(Way(GetParam(), proxy.endpoint()).fetch(1), proxy);
    }
  }
}

TEST_P(Resume, ContinuesWhileEachConnectionBringsATile) {
  const CuttingProxy proxy({server_.endpoint()}, [](int) { return Cut{.tiles = 1}; });
  expect_the_same(Way(GetParam(), proxy.endpoint()).fetch(1), proxy);
  EXPECT_GE(static_cast<std::size_t>(proxy.connections()), tiles_);
}

TEST_P(Resume, GivesUpWithoutProgress) {
  for (const int retries : {0, 1, 3}) {
    const CuttingProxy proxy({server_.endpoint()}, [](int) { return Cut{.messages = 3}; });
    const auto steps = Way(GetParam(), proxy.endpoint()).fetch(retries);
    ASSERT_FALSE(steps);
    EXPECT_EQ(steps.error().source, ErrorSource::kNetwork);
    EXPECT_EQ(steps.error().error.code, ErrorCode::kUnavailable);
    EXPECT_EQ(proxy.connections(), 1 + retries);
  }
}

TEST_P(Resume, RejectsAReplacedDataset) {
  const RunningServer other(gyroid(/*amplitude=*/0.3));
  const CuttingProxy proxy({server_.endpoint(), other.endpoint()},
                           [](int i) { return i == 0 ? Cut{.tiles = 1} : Cut{}; });
  const auto steps = Way(GetParam(), proxy.endpoint()).fetch(3);
  ASSERT_FALSE(steps);
  EXPECT_EQ(steps.error().error.code, ErrorCode::kUnknownDataset);
}

// A resumed stream repeats its final step of shells even if a new plan would end differently.
TEST(ResumeToDisplay, RepeatsNoTileOrStepAfterACutAtAnyMessage) {
  const RunningServer server(shared_gyroid());
  const auto digests_of = [](const ClientResult<std::vector<FetchedStep>>& steps) {
    std::vector<ContentDigest> digests;
    if (!steps) ADD_FAILURE() << steps.error().error.text;
    EXPECT_TRUE(steps && steps->back().step->begin.shell);
    for (std::size_t i = 0; steps && i < steps->size(); ++i) {
      digests.push_back((*steps)[i].step->end.digest);
    }
    return digests;
  };
  const CuttingProxy whole({server.endpoint()}, [](int) { return Cut{}; });
  const auto expected = digests_of(fetch_from(whole.endpoint(), 0, {}, MeshUse::kDisplay));
  const std::size_t tiles = whole.tiles().size();
  for (std::size_t passed = 2; passed < static_cast<std::size_t>(whole.messages()); ++passed) {
    SCOPED_TRACE(::testing::Message() << "cut after " << passed);
    const CuttingProxy proxy({server.endpoint()},
                             [&](int i) { return i == 0 ? Cut{.messages = passed} : Cut{}; });
    EXPECT_EQ(digests_of(fetch_from(proxy.endpoint(), 1, {}, MeshUse::kDisplay)), expected);
    EXPECT_TRUE(are_distinct(proxy.tiles()));
    EXPECT_EQ(proxy.tiles().size(), tiles);
  }
}

std::string name_of(const ::testing::TestParamInfo<Transport>& way) {
  return std::array{"OverTcp", "OverTls", "OverWebSocket", "OverSecureWebSocket"}.at(
      static_cast<std::size_t>(way.param));
}
INSTANTIATE_TEST_SUITE_P(, Resume,
                         ::testing::Values(Transport::kTcp, Transport::kTls, Transport::kWebSocket,
                                           Transport::kSecureWebSocket),
                         name_of);

// ---- the program and its tile folder

class ResumeOfProgram : public Resume {
 protected:
  [[nodiscard]] pid_t start(const Endpoint& server, const Trust& trust = {}) const {
    std::vector<std::string> words = {MULTITETRA_CLIENT_PROGRAM,
                                      "fetch",
                                      "--server",
                                      to_string(server),
                                      "--dataset",
                                      "gyroid",
                                      "--isovalue",
                                      "0.1",
                                      "--error",
                                      "0.25",
                                      "--simplify",
                                      "off",
                                      "--resume",
                                      (folder_ / "tiles").string(),
                                      "--report",
                                      (folder_ / "report.json").string(),
                                      "-o",
                                      (folder_ / "mesh.ply").string(),
                                      "--quiet"};
    if (!trust.ca_file.empty()) words.insert(words.end(), {"--ca", trust.ca_file});
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    pid_t process = -1;
    EXPECT_EQ(
        ::posix_spawn(&process, words[0].c_str(), nullptr, nullptr, arguments.data(), environ), 0);
    return process;
  }
  static int exit_code_of(pid_t process) {
    int status = 0;
    ::waitpid(process, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] std::vector<fs::path> tile_files() const {
    std::vector<fs::path> files;
    std::error_code none_yet;
    for (const auto& entry : fs::directory_iterator(folder_ / "tiles", none_yet)) {
      if (entry.path().extension() == ".tile") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
  }
  [[nodiscard]] nlohmann::json report() const {
    return nlohmann::json::parse(std::ifstream(folder_ / "report.json"));
  }
  [[nodiscard]] bool has_the_whole_surface() const {
    return report().at("steps").back().at("content_digest") == digests_.back().hex();
  }

  TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
};

TEST_P(ResumeOfProgram, ContinuesAKilledRun) {
  const std::size_t enough = final_tiles_ / 2;
  std::vector<ContentDigest> sent;
  {
    const CuttingProxy proxy({server_.endpoint()},
                             [&](int) { return Cut{.tiles = enough, .stays_open = true}; });
    const Way way(GetParam(), proxy.endpoint());
    const pid_t process = start(way.endpoint(), way.trust());
    EXPECT_TRUE(testing::eventually([&] { return tile_files().size() >= enough; }));
    ::kill(process, SIGKILL);
    EXPECT_EQ(exit_code_of(process), -1);
    sent = proxy.tiles();
  }
  ASSERT_EQ(tile_files().size(), enough);
  ASSERT_EQ(sent.size(), enough);

  const CuttingProxy proxy({server_.endpoint()}, [](int) { return Cut{}; });
  EXPECT_EQ(exit_code_of(start(proxy.endpoint())), 0);
  EXPECT_TRUE(has_the_whole_surface());
  for (const ContentDigest& tile : proxy.tiles()) sent.push_back(tile);
  EXPECT_TRUE(are_distinct(sent));
  EXPECT_EQ(sent.size(), final_tiles_);
  EXPECT_EQ(report().at("tiles_held"), enough);
  EXPECT_EQ(report().at("tiles_received"), final_tiles_ - enough);
}

TEST_P(ResumeOfProgram, RefetchesADamagedFile) {
  ASSERT_EQ(exit_code_of(start(server_.endpoint())), 0);
  const auto files = tile_files();
  ASSERT_EQ(files.size(), final_tiles_);
  fs::resize_file(files[0], fs::file_size(files[0]) / 2);
  {
    std::fstream file(files[1], std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(fs::file_size(files[1]) / 2));
    file << "damage";
  }
  fs::copy_file(files[3], files[2], fs::copy_options::overwrite_existing);
  const CuttingProxy proxy({server_.endpoint()}, [](int) { return Cut{}; });
  EXPECT_EQ(exit_code_of(start(proxy.endpoint())), 0);
  EXPECT_TRUE(has_the_whole_surface());
  EXPECT_EQ(proxy.tiles().size(), 3U);
  EXPECT_EQ(exit_code_of(start(server_.endpoint())), 0);
  EXPECT_EQ(report().at("tiles_held"), final_tiles_) << "they are whole again";
}

INSTANTIATE_TEST_SUITE_P(, ResumeOfProgram,
                         ::testing::Values(Transport::kTcp, Transport::kSecureWebSocket), name_of);

}  // namespace
}  // namespace multitetra

// A server of datasets that were forged with matching checksums answers every request, and lives.
#include <filesystem>

#include <gtest/gtest.h>

#include "common/base/percent_encoded.hpp"
#include "server/dataset/prepare.hpp"
#include "server/service/detail/worker_jobs.hpp"
#include "server/stream/stream_messages.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/forged_datasets.hpp"
#include "tests/support/running_http_server.hpp"
#include "tests/support/served_datasets.hpp"
#include "tests/support/sweep.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;
using testing::DatasetForger;
using testing::HttpClient;
using testing::RunningHttpServer;

// Prepares small datasets of several types of samples and returns their files.
std::vector<std::string> whole_files() {
  const TemporaryFolder folder;
  std::vector<std::string> files;
  const auto add = [&](Volume volume, std::optional<double> outside, int margin) {
    const auto file = folder.path() / "whole.mtd";
    prepare(*source_of(std::move(volume)), {.name = "forged", .outside = outside, .margin = margin},
            file, {});
    files.push_back(bytes_of_file(file));
  };
  add(fields::gyroid(20, 0.3, 8), std::nullopt, 0);
  add(fields::integer_noise({21, 18, 35}, 50, 6), 30.5, 1);
  add(fields::masked_gyroid(19, 10), std::nullopt, 2);
  return files;
}

// Opens a file; null if that fails.
DatasetPtr opened(const std::string& bytes) {
  const TemporaryFolder folder;
  try {
    return open_dataset(folder.file("forged.mtd", bytes).string());
  } catch (const DatasetFileError&) {
    return nullptr;
  }
}

std::vector<double> isovalues(const DatasetInfo& info) {
  std::vector<double> values = info.suggested_isovalues;
  values.push_back(info.min / 2 + info.max / 2);
  values.push_back(0.1);
  return values;
}

// Streams previews and the final surface of a dataset as a worker does, also in shells.
void stream_all(const DatasetPtr& dataset) {
  const auto source =
      std::make_shared<CachingSurfaceProvider>(std::make_shared<const SurfaceExtractor>(dataset));
  for (const double isovalue : isovalues(dataset->info)) {
    for (const bool shells : {false, true}) {
      OpenStream open{.dataset = dataset->info.name,
                      .request = {.isovalue = isovalue, .error = 0.25, .simplify = true}};
      const ValidatedStream action{.open = open, .source = source, .shells = shells};
      StreamMessages messages(open, dataset->info, std::nullopt, shells);
      while (const auto state = messages.take_request()) {
        auto made = make_steps(action, *state, 0, {}, {});
        if (!made) {
          EXPECT_NE(made.error().code, ErrorCode::kInternal) << made.error().text;
          break;
        }
        messages.supply(std::move(made->front()), 0.001);
        while (messages.has_message()) (void)messages.take();
      }
    }
  }
}

TEST(ForgedDatasets, AreServedOrRefused) {
  const int count = testing::sweep(14, 240);
  const std::vector<std::string> whole = whole_files();
  const DatasetPtr good = make_dataset(fields::gyroid(20, 0.3, 8), "good");
  int served = 0;
  for (int seed = 0; seed < count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    DatasetForger forger(whole[static_cast<std::size_t>(seed) % whole.size()],
                         static_cast<std::uint32_t>(seed));
    const DatasetPtr forged = opened(forger.forged());
    if (!forged || forged->info.name == "good") continue;
    ++served;
    const RunningHttpServer server(testing::catalogue_with({good, forged}));
    HttpClient client(server.http());
    const std::string place = "/v1/datasets/" + percent_encoded(forged->info.name);
    const auto get = [&](const std::string& target) {
      const auto answer = client.get(target);
      if (answer.result_int() >= 400) {
        EXPECT_NE(testing::error_code_of(answer), "internal") << target << ": " << answer.body();
      }
      return answer.result_int();
    };
    EXPECT_EQ(get("/v1/datasets"), 200U);
    get(place);
    get(place + "/thumbnail.png");
    get(place + "/slice?axis=z");
    get(place + "/slice?axis=x&format=raw");
    get(place + "/probe?at=3,4,5&at=0,0,0&coordinates=index");
    get("/v1/datasets/good/isosurface?isovalue=0.1&error=1&format=ply&color_anyway=true&color_by=" +
        percent_encoded(forged->info.name));
    for (const double isovalue : isovalues(forged->info)) {
      const std::string value = "isovalue=" + std::to_string(isovalue);
      get(place + "/isosurface?format=ply&error=0&" + value);
      get(place + "/isosurface?format=glb&error=1&" + value);
      get(place + "/isosurface?format=stl&error=0.5&max_triangles=100&" + value);
    }
    EXPECT_EQ(get("/livez"), 200U);
    stream_all(forged);
  }
  EXPECT_GT(served, count / 8) << count;
}

// Returns the text of the error of opening the dataset; "none" if it can be opened.
std::string error_of_opening(const std::string& bytes) {
  const TemporaryFolder folder;
  try {
    (void)open_dataset(folder.file("forged.mtd", bytes).string());
    return "none";
  } catch (const DatasetFileError& error) {
    return error.what();
  }
}

TEST(ForgedDatasets, NeedSamplesInEveryBrick) {
  for (const std::string& file : whole_files()) {
    for (const std::size_t brick : {0U, 1U}) {
      DatasetForger forger(file, 0);
      EXPECT_EQ(error_of_opening(forger.file()), "none");
      forger.replace_sample_brick(brick, BrickCodec::kRaw, "");
      EXPECT_NE(error_of_opening(forger.file()).find("a brick of samples is empty"),
                std::string::npos);
    }
  }
}

}  // namespace
}  // namespace multitetra

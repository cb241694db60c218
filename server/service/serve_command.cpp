#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "server/dataset/dataset.hpp"
#include "server/gateway/http_door.hpp"
#include "server/service/commands.hpp"
#include "server/service/server.hpp"
#include "server/service/step_source.hpp"
#include "server/service/surface_extractor.hpp"
#include "server/service/thread_options.hpp"

namespace multitetra {
namespace {

struct Arguments {
  std::vector<std::string> inputs;
  std::string tcp = to_string(Endpoint{.host = "127.0.0.1"});
  std::string http = http_url(HttpOptions{}.listen);
  std::vector<std::string> allowed_origins;
  int threads = 0;
  std::size_t cache_bytes = std::size_t{512} << 20;
};

// The files themselves, and those named *.mtd in directories, each once, in order.
std::vector<std::filesystem::path> dataset_files(const std::vector<std::string>& inputs) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path input : inputs) {
    if (!std::filesystem::is_directory(input)) {
      files.push_back(input);
      continue;
    }
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(input)) {
      if (entry.path().extension() == ".mtd") found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

// A dataset that cannot be served is told and left out.
CataloguePtr open_all(const std::vector<std::filesystem::path>& files, std::size_t cache_bytes) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  const auto pool = std::make_shared<CubeMemoryPool>();
  const auto cache = std::make_shared<StepCache>(cache_bytes);
  for (const std::filesystem::path& file : files) {
    try {
      const DatasetPtr dataset = open_dataset(file);
      catalogue->add(std::make_shared<ExtractedSteps>(
          std::make_shared<SurfaceExtractor>(dataset, pool), cache));
      spdlog::info("serving \"{}\" from {}: {} x {} x {} {}", dataset->info.name, file.string(),
                   dataset->info.dims[0], dataset->info.dims[1], dataset->info.dims[2],
                   name(dataset->info.type));
    } catch (const std::exception& error) {
      spdlog::error("left out: {}", error.what());
    }
  }
  return catalogue;
}

std::vector<MakeDoor> more_doors(const Arguments& arguments) {
  if (arguments.http == "off") return {};
  const Result<Endpoint> endpoint = parse_http_endpoint(arguments.http);
  if (!endpoint) throw std::invalid_argument("--http: " + endpoint.error().text);
  const HttpOptions options = {.listen = *endpoint, .allowed_origins = arguments.allowed_origins};
  return {[options](const House& house) { return std::make_unique<HttpDoor>(house, options); }};
}

int serve(const Arguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  spdlog::set_default_logger(spdlog::stderr_color_mt("multitetra-server"));
  const Result<Endpoint> endpoint = parse_endpoint(arguments.tcp);
  if (!endpoint) throw std::invalid_argument("--tcp: " + endpoint.error().text);
  const CataloguePtr catalogue = open_all(dataset_files(arguments.inputs), arguments.cache_bytes);
  if (catalogue->size() == 0) {
    throw std::runtime_error(
        "No dataset to serve; make one with: multitetra-server prepare VOLUME -o FILE.mtd");
  }
  // Each step uses all threads; a second one at the same time fills what the first leaves idle.
  const std::size_t workers = arguments.threads == 1 ? 1 : 2;
  Server server(catalogue, {.listen = *endpoint, .workers = workers, .stop_on_signals = true},
                more_doors(arguments));
  spdlog::info("listening on {}", to_string(server.endpoint()));
  if (arguments.http != "off") spdlog::info("listening on {}", http_url(server.endpoint(1)));
  server.run();
  spdlog::info("stopped");
  return 0;
}

}  // namespace

void add_serve_command(CLI::App& program, Run& run) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* command =
      program.add_subcommand("serve", "Serve datasets to clients until stopped (Ctrl-C)");
  command->add_option("inputs", a->inputs, "Dataset files, or directories of them (.mtd)")
      ->required();
  command->add_option("--tcp", a->tcp, "Address and port to listen on; port 0 takes a free one")
      ->capture_default_str();
  command
      ->add_option("--http", a->http, "Address and port for HTTP and WebSockets; off: no such door")
      ->capture_default_str();
  command->add_option("--allow-origin", a->allowed_origins,
                      "Web pages of this origin, for example https://example.org, may use the "
                      "HTTP door besides its own; * allows all (repeatable)");
  command
      ->add_option("--cache-bytes", a->cache_bytes,
                   "Memory for encoded tiles that are kept for the next request, for example "
                   "512MiB; 0 keeps none")
      ->transform(CLI::AsSizeValue(/*kb_is_1000=*/false))
      ->capture_default_str();
  add_threads_option(*command, a->threads);
  command->footer(
      "Examples:\n"
      "  multitetra-server serve head.mtd\n"
      "  multitetra-server serve datasets/ --tcp 0.0.0.0:7410 --threads 8");
  command->callback([a, &run] { run = [a] { return serve(*a); }; });
}

}  // namespace multitetra

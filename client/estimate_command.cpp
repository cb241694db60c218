#include "client/estimate_command.hpp"

#include <algorithm>
#include <iostream>

#include "client/program.hpp"
#include "common/human_units.hpp"
#include "common/json_report.hpp"

namespace multitetra {
namespace {

void print(const EstimateReply& reply, const IsosurfaceRequest& request) {
  std::cout << "about " << human_count(reply.triangles) << " triangles, "
            << human_bytes(reply.bytes) << ", at an error of at most " << reply.threshold_world
            << " world units"
            << (request.max_triangles + request.max_bytes > 0
                    ? ", which is what fits into the budget"
                    : "")
            << "\n";
}

}  // namespace

void add_estimate(CLI::App& app, EstimateArguments& a) {
  CLI::App* command =
      app.add_subcommand("estimate", "Tell how large an isosurface would be, without making it");
  add_server_options(*command, a.server);
  command->add_option("--dataset", a.dataset, "Name of the dataset, as `list` tells")->required();
  add_surface_options(*command, a.surface);
  command->add_flag("--json", a.json, "Print JSON");
  command->footer(
      std::string("Examples:\n"
                  "  multitetra-client estimate --dataset head --isovalue 500.5 --error 1\n"
                  "  multitetra-client estimate --dataset head --max-bytes 1000000 --json\n") +
      kExitCodes);
}

int estimate(const EstimateArguments& arguments) {
  const auto access = access_of(arguments.server);
  if (!access) return complain(kUsage, access.error().text);
  auto client = Client::connect(access->server, access->options);
  if (!client) return complain(client.error());
  const auto datasets = client->list_datasets();
  if (!datasets) return complain(datasets.error());
  const auto info =
      std::find_if(datasets->begin(), datasets->end(),
                   [&](const DatasetInfo& dataset) { return dataset.name == arguments.dataset; });
  if (info == datasets->end()) {
    return complain(kFailed, "The server has no dataset \"" + arguments.dataset +
                                 "\"; `multitetra-client list` tells those that it has.");
  }
  const auto request = request_of(arguments.surface, *info);
  if (!request) return complain(kUsage, request.error().text);
  const auto reply = client->estimate(arguments.dataset, *request);
  if (!reply) return complain(reply.error());
  if (arguments.json) {
    const Json report = {{"dataset", arguments.dataset},
                         {"parameters", json_of(*request)},
                         {"triangles", reply->triangles},
                         {"bytes", reply->bytes},
                         {"threshold_world", reply->threshold_world}};
    std::cout << text_of(report);
  } else {
    print(*reply, *request);
  }
  return kOk;
}

}  // namespace multitetra

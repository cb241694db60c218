#include "client/commands/estimate_command.hpp"

#include <iostream>

#include <nlohmann/json.hpp>

#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"

namespace multitetra {
namespace {

void print(const EstimateReply& reply, const IsosurfaceRequest& request, const DatasetInfo& info) {
  std::cout << "isovalue " << shortest_text(request.isovalue) << ": about "
            << human_count_of(reply.triangles, "triangle") << ", " << human_bytes(reply.bytes)
            << ", at an error of at most " << human_error(reply.threshold_world, request.unit, info)
            << (request.max_triangles + request.max_bytes > 0
                    ? ", which is what fits into the budget"
                    : "")
            << "\n";
}

}  // namespace

void add_estimate(Command& app, EstimateArguments& a) {
  Command* command =
      app.add_subcommand("estimate", "Estimate the size of an isosurface without making it");
  add_order_options(*command, a.order,
                    {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize});
  command->add_flag("--json", a.json, "Print JSON");
  command->footer(
      std::string("Sizes are mostly within a third of the real ones; those of large smooth "
                  "surfaces within a\n"
                  "factor of three. Budgets hold for the surface itself.\n"
                  "Examples:\n"
                  "  multitetra-client estimate --dataset head --isovalue 500.5 --error 1\n"
                  "  multitetra-client estimate --dataset head --max-bytes 1000000 --json\n") +
      kExitCodes);
}

int estimate(const EstimateArguments& arguments) {
  if (arguments.order.surface.query.isovalues.size() > 1) {
    return print_error(kUsage, "--isovalue: an estimate is about one surface; give one isovalue.");
  }
  auto surface = ordered(arguments.order);
  if (!surface) return surface.error();
  const auto reply = surface->client.estimate(surface->info.name, surface->requests.front());
  if (!reply) return print_error(reply.error());
  if (arguments.json) {
    const Json report = {{"server", to_string(surface->server)},
                         {"dataset", surface->info.name},
                         {"parameters", json_of(surface->requests.front())},
                         {"notices", surface->notices.texts()},
                         {"triangles", reply->triangles},
                         {"bytes", reply->bytes},
                         {"threshold_world", reply->threshold_world}};
    std::cout << text_of(report);
  } else {
    print(*reply, surface->requests.front(), surface->info);
  }
  return kOk;
}

}  // namespace multitetra

#include <iostream>
#include <memory>

#include "client/commands/commands.hpp"
#include "client/commands/connected_request.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"
#include "common/request/estimate_range.hpp"

namespace multitetra {
namespace {

struct EstimateArguments {
  SurfaceOrder order;
  bool json = false;
};

void print(const EstimateReply& reply, const IsosurfaceRequest& request, const DatasetInfo& info) {
  const TriangleRange range = expected_triangles(reply.triangles, request.max_triangles);
  std::cout << "isovalue " << shortest_text(request.isovalue) << ": "
            << (range.least < range.most ? human_count(range.least) + " to " : "")
            << human_count_of(range.most, "triangle") << ", about " << human_bytes(reply.bytes)
            << ", at an error of at most "
            << human_error(reply.error_bound_world, request.unit, info)
            << (request.max_triangles + request.max_bytes > 0
                    ? ", the smallest that fits the budget"
                    : "")
            << "\n";
}

Json json_of(const EstimateReply& reply, const DatasetRequest& surface) {
  const IsosurfaceRequest& request = surface.requests.front();
  const TriangleRange range = expected_triangles(reply.triangles, request.max_triangles);
  return {{"dataset", surface.info.name},
          {"parameters", multitetra::json_of(request)},
          {"notices", surface.notices.texts()},
          {"triangles", reply.triangles},
          {"triangles_least", range.least},
          {"triangles_most", range.most},
          {"bytes", reply.bytes},
          {"error_bound_world", reply.error_bound_world}};
}

int estimate(const EstimateArguments& arguments) {
  if (arguments.order.surface.query.isovalues.size() > 1) {
    throw ExitError(kUsage, "--isovalue: an estimate is for one surface; give one isovalue.");
  }
  ConnectedRequests connected = ordered_datasets(arguments.order);
  share_budget(connected);
  Json surfaces = Json::array();
  for (const DatasetRequest& surface : connected.datasets) {
    const auto reply = connected.client.estimate(surface.info.name, surface.requests.front());
    if (!reply) exit_with(reply.error());
    if (arguments.json) {
      surfaces.push_back(json_of(*reply, surface));
    } else {
      if (connected.is_series) std::cout << surface.info.name << ", ";
      print(*reply, surface.requests.front(), surface.info);
    }
  }
  if (!arguments.json) return kOk;
  Json report = {{"server", to_string(connected.server)}};
  if (connected.is_series) {
    report["surfaces"] = std::move(surfaces);
  } else {
    report.update(surfaces.front());
  }
  std::cout << text_of(report);
  return kOk;
}

}  // namespace

void add_estimate(Command& program, Run& run) {
  const auto a = std::make_shared<EstimateArguments>();
  Command* command =
      program.add_subcommand("estimate", "Estimate the size of an isosurface without making it");
  add_order_options(*command, a->order,
                    {FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize});
  command->add_flag("--json", a->json, "Print JSON");
  command->footer(
      std::string("Most surfaces have about this many triangles; large smooth ones may have a "
                  "third of that.\n"
                  "The surface itself stays within its budget.\n"
                  "Examples:\n"
                  "  multitetra-client estimate --dataset head --isovalue 500.5 --error 1\n"
                  "  multitetra-client estimate --dataset head --max-bytes 1000000 --json\n") +
      kExitCodes);
  command->callback([a, &run] { run = [a] { return estimate(*a); }; });
}

}  // namespace multitetra

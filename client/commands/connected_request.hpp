// Turns a command's options into a connected server and a validated surface request, as all
// commands for one surface need.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "client/commands/program.hpp"
#include "client/commands/server_options.hpp"
#include "client/library/client.hpp"
#include "client/library/isolated_thresholds.hpp"
#include "common/cli/command.hpp"
#include "common/cli/surface_options.hpp"
#include "common/cli/surface_output.hpp"
#include "common/cli/terminal.hpp"

namespace multitetra {

struct ConnectedServer {
  Endpoint server;
  Client client;
  std::vector<DatasetInfo> datasets;
};

// Connects and lists the datasets. Throws ExitError, as all functions here do.
[[nodiscard]] ConnectedServer connected_to(const ServerArguments& arguments,
                                           const RetryOptions& retries = {.most = 0});

// The dataset and surface that a command requests. An empty name selects the only dataset.
struct SurfaceOrder {
  ServerArguments server = {};
  std::string dataset = {};
  SurfaceArguments surface = {
      .threshold_files = {.formats = "An NRRD file", .read = read_thresholds_isolated}};
  // Prints no notices.
  bool quiet = false;
};

// Adds all options of an order with the request fields of these groups.
void add_order_options(Command& command, SurfaceOrder& order,
                       std::initializer_list<FieldGroup> fields);

// An order for one dataset.
struct DatasetRequest {
  DatasetInfo info;
  // At least one, each with the whole budget; `snapshot` of a volume alone removes them.
  std::vector<IsosurfaceRequest> requests;
  // The colors of every surface; nullopt: no colors.
  std::optional<ScalarRequest> scalars;
  Notices notices;              // Warnings about the requests.
  std::string color_unit = {};  // The unit of the colored values; empty: unknown.
};

struct ConnectedRequests {
  Endpoint server;
  Client client;
  std::vector<DatasetRequest> datasets;  // At least one.
  bool is_series = false;
};
// Connects to the server of the order and returns its request. An order may name a series, or a
// field of one ("flow.density"): then there is a request for each of its datasets. A field of the
// series that colors them does so at their times, with one range.
[[nodiscard]] ConnectedRequests ordered_datasets(const SurfaceOrder& order,
                                                 const RetryOptions& retries = {.most = 0});

// Divides the budget among the surfaces of each time, in proportion to sizes estimated by the
// server.
void share_budget(ConnectedRequests& connected);

// Makes the output of a final step, with its report and notices. Prints the accuracy of colors
// unless `output` is quiet.
void finish(OutputPart& part, const CommittedStep& step,
            const std::optional<ScalarRequest>& scalars, const SurfaceArguments& arguments,
            const OutputArguments& output);

}  // namespace multitetra

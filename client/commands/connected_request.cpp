#include "client/commands/connected_request.hpp"

#include <algorithm>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/base/nearest_word.hpp"
#include "common/request/request_notices.hpp"

namespace multitetra {
namespace {

using Connected = std::pair<Client, std::vector<DatasetInfo>>;

ClientResult<Connected> connected_once(const ServerAccess& access) {
  auto client = Client::connect(access.server, access.options);
  if (!client) return tl::unexpected(client.error());
  auto datasets = client->list_datasets();
  if (!datasets) return tl::unexpected(datasets.error());
  return Connected(*std::move(client), *std::move(datasets));
}

// Returns the names that a user sees in lists: of series, and of datasets that are in none.
std::vector<std::string> names(const std::vector<DatasetInfo>& datasets) {
  std::vector<std::string> names;
  for (const DatasetInfo& info : datasets) {
    const std::string& name = info.member ? info.member->series : info.name;
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

// Returns a hint for a server error; empty if the error is clear.
std::string advice(const ClientError& failure) {
  if (failure.error.code != ErrorCode::kUnauthenticated) return "";
  return "Give the token that you were sent with --token-file FILE or MULTITETRA_TOKEN.";
}

// Returns the named dataset, or the only one if the name is empty.
Result<DatasetInfo> chosen(const std::string& name, const std::vector<DatasetInfo>& datasets) {
  if (datasets.empty()) {
    return fail(ErrorCode::kUnknownDataset, "The server has no dataset that this client may see.");
  }
  if (name.empty() && datasets.size() == 1) return datasets.front();
  if (name.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "The server has several datasets; choose one with --dataset: " +
                    few_of(name, names(datasets)) + ".");
  }
  const auto found = std::find_if(datasets.begin(), datasets.end(),
                                  [&](const DatasetInfo& info) { return info.name == name; });
  if (found != datasets.end()) return *found;
  for (const DatasetInfo& info : datasets) {
    if (!info.member || info.member->series != name) continue;
    return fail(ErrorCode::kUnknownDataset, "\"" + name +
                                                "\" is a series of datasets; choose one of them, "
                                                "as --dataset " +
                                                info.name + ".");
  }
  std::vector<std::string> known = names(datasets);
  const std::string some = few_of(name, known);
  for (const DatasetInfo& info : datasets) known.push_back(info.name);
  return fail(ErrorCode::kUnknownDataset, "The server has no dataset \"" + name + "\"; it has " +
                                              some + "." + did_you_mean(name, known));
}

DatasetInfo usable_dataset(const SurfaceOrder& order, const ConnectedServer& connected) {
  auto info = chosen(order.dataset, connected.datasets);
  if (info) return *std::move(info);
  const bool is_usage = info.error().code == ErrorCode::kInvalidArgument;
  throw ExitError(is_usage ? kUsage : kFailed, info.error().text);
}

DatasetRequest request_for(DatasetInfo info, const SurfaceOrder& order,
                           const ConnectedServer& connected) {
  auto requests = value_or_usage_error(requests_from(order.surface, info));
  auto scalars = value_or_usage_error(scalars_for(order.surface.query));
  std::string color_unit;
  for (const DatasetInfo& values : connected.datasets) {
    if (!scalars || values.name != scalars->dataset) continue;
    const auto fits = check_same_world(*scalars, info, values);
    if (!fits) throw ExitError(kUsage, fits.error().text);
    color_unit = values.meaning.value_unit;
  }
  Notices notices(order.quiet);
  for (const IsosurfaceRequest& request : requests) notices.add(request_notices(request, info));
  return {std::move(info), std::move(requests), std::move(scalars), std::move(notices),
          std::move(color_unit)};
}

}  // namespace

ConnectedServer connected_to(const ServerArguments& arguments, const RetryOptions& retry_options) {
  const ServerAccess access = value_or_usage_error(access_of(arguments));
  Retries retries(retry_options);
  auto connected = connected_once(access);
  while (!connected && retries.wait_after(connected.error().error)) {
    connected = connected_once(access);
  }
  if (!connected) {
    ClientError failure = connected.error();
    const std::string more = advice(failure);
    if (!more.empty()) failure.error.text += " " + more;
    exit_with(failure);
  }
  auto& [client, datasets] = *connected;
  return {access.server, std::move(client), std::move(datasets)};
}

void add_order_options(Command& command, SurfaceOrder& order,
                       std::initializer_list<FieldGroup> fields) {
  command
      .add_option("--dataset", order.dataset,
                  "Name of the dataset, from `list`; required if there are several")
      ->type_name("NAME");
  add_request_options(command, order.surface, fields);
  add_server_options(command, order.server);
}

ConnectedRequest ordered(const SurfaceOrder& order, const RetryOptions& retries) {
  ConnectedServer connected = connected_to(order.server, retries);
  DatasetRequest request = request_for(usable_dataset(order, connected), order, connected);
  return {std::move(request), connected.server, std::move(connected.client)};
}

ConnectedRequests ordered_datasets(const SurfaceOrder& order, const RetryOptions& retries) {
  ConnectedServer connected = connected_to(order.server, retries);
  std::vector<DatasetInfo> members;
  for (const DatasetInfo& info : connected.datasets) {
    if (info.name == order.dataset) {
      members.clear();
      break;
    }
    if (info.member && info.member->series == order.dataset) members.push_back(info);
  }
  const bool is_series = !members.empty();
  if (!is_series) members.push_back(usable_dataset(order, connected));
  std::vector<DatasetRequest> datasets;
  for (DatasetInfo& info : members) {
    datasets.push_back(request_for(std::move(info), order, connected));
  }
  return {connected.server, std::move(connected.client), std::move(datasets), is_series};
}

void share_budget(ConnectedRequests& connected) {
  DatasetRequest& first = connected.datasets.front();
  if (connected.is_series) {
    const IsosurfaceRequest& request = first.requests.front();
    if (request.max_triangles == 0 && request.max_bytes == 0) return;
    throw ExitError(kUsage, "--max-triangles and --max-bytes are for one dataset, not a series.");
  }
  const auto shared = connected.client.share_budget(first.info.name, first.requests);
  if (!shared) exit_with(shared.error());
}

}  // namespace multitetra

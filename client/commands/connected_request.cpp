#include "client/commands/connected_request.hpp"

#include <algorithm>
#include <iostream>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "client/library/report.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/nearest_word.hpp"
#include "common/request/request_notices.hpp"
#include "common/request/shared_budget.hpp"

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

// Returns the name of a member without its time: "flow.density" of "flow.density.t0003".
std::string field_name(const DatasetInfo& info) {
  return info.member->time ? info.name.substr(0, info.name.rfind('.')) : info.name;
}

// Returns whether a dataset belongs to the series, or to the field of a series.
bool is_of_series(const DatasetInfo& info, const std::string& name) {
  return info.member && (name == info.member->series || name == field_name(info));
}

// Fails if isovalues are given for several fields, whose values differ.
void require_one_field(const SurfaceOrder& order, const std::vector<DatasetInfo>& members) {
  if (order.surface.query.isovalues.empty()) return;
  std::set<std::string> fields;
  for (const DatasetInfo& info : members) {
    if (!info.member->label) fields.insert(field_name(info));
  }
  if (fields.size() < 2) return;
  throw ExitError(
      kUsage, "\"" + order.dataset + "\" has several fields, and isovalues are for one. " +
                  "Choose one with --dataset: " + few_of("", {fields.begin(), fields.end()}) + ".");
}

// The values that color a surface: those of the named dataset, or of the named field of the
// surface's series at the same time.
void choose_colors(ScalarRequest& scalars, const DatasetInfo& info,
                   const std::vector<DatasetInfo>& datasets) {
  const auto is_named = [&](const DatasetInfo& one) { return one.name == scalars.dataset; };
  if (!info.member || std::any_of(datasets.begin(), datasets.end(), is_named)) return;
  std::vector<const DatasetInfo*> times;
  for (const DatasetInfo& one : datasets) {
    if (!one.member || one.member->label || one.member->series != info.member->series) continue;
    const bool is_field =
        scalars.dataset == one.member->field || scalars.dataset == field_name(one);
    if (is_field) times.push_back(&one);
  }
  const auto now = std::find_if(times.begin(), times.end(), [&](const DatasetInfo* one) {
    return one->member->time == info.member->time;
  });
  if (now == times.end()) return;
  scalars.dataset = (*now)->name;
  if (scalars.limits) return;
  // One range for all times, so that colors are comparable.
  ScalarRequest::Limits limits{.low = (*now)->min, .high = (*now)->max};
  for (const DatasetInfo* const one : times) {
    limits = {.low = std::min(limits.low, one->min), .high = std::max(limits.high, one->max)};
  }
  if (limits.low < limits.high) scalars.limits = limits;
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
  if (scalars) choose_colors(*scalars, info, connected.datasets);
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

// The same isovalue at all times of a field: by default the suggestion of the first.
SurfaceOrder order_for(const DatasetInfo& info, const SurfaceOrder& order,
                       const std::vector<DatasetInfo>& members) {
  SurfaceOrder one = order;
  if (!order.surface.query.isovalues.empty() || !info.member || info.member->label) return one;
  const DatasetInfo* first = &info;
  for (const DatasetInfo& other : members) {
    const bool is_same = !other.member->label && field_name(other) == field_name(info);
    if (is_same && other.member->time < first->member->time) first = &other;
  }
  if (first != &info && !first->suggested_isovalues.empty()) {
    one.surface.query.isovalues = {first->suggested_isovalues.front()};
  }
  return one;
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

ConnectedRequests ordered_datasets(const SurfaceOrder& order, const RetryOptions& retries) {
  ConnectedServer connected = connected_to(order.server, retries);
  std::vector<DatasetInfo> members;
  for (const DatasetInfo& info : connected.datasets) {
    if (info.name == order.dataset) {
      members.clear();
      break;
    }
    if (is_of_series(info, order.dataset)) members.push_back(info);
  }
  const bool is_series = !members.empty();
  if (is_series) require_one_field(order, members);
  if (!is_series) members.push_back(usable_dataset(order, connected));
  std::vector<DatasetRequest> datasets;
  for (const DatasetInfo& info : members) {
    const SurfaceOrder one = is_series ? order_for(info, order, members) : order;
    datasets.push_back(request_for(info, one, connected));
  }
  return {connected.server, std::move(connected.client), std::move(datasets), is_series};
}

void share_budget(ConnectedRequests& connected) {
  // Surfaces of one time are one scene; nullopt: no time.
  std::map<std::optional<double>, std::vector<DatasetRequest*>> scenes;
  for (DatasetRequest& one : connected.datasets) {
    scenes[connected.is_series ? one.info.member->time : std::nullopt].push_back(&one);
  }
  for (const auto& [time, scene] : scenes) {
    std::vector<std::string> names;
    std::vector<IsosurfaceRequest> requests;
    for (const DatasetRequest* const one : scene) {
      names.insert(names.end(), one->requests.size(), one->info.name);
      requests.insert(requests.end(), one->requests.begin(), one->requests.end());
    }
    if (const auto fits = check_shared_budget(requests); !fits) {
      throw ExitError(kUsage, fits.error().text);
    }
    const auto shared = connected.client.share_budget(names, requests);
    if (!shared) exit_with(shared.error());
    auto share = requests.begin();
    for (DatasetRequest* const one : scene) {
      for (IsosurfaceRequest& request : one->requests) request = *share++;
    }
  }
}

void finish(OutputPart& part, const CommittedStep& step,
            const std::optional<ScalarRequest>& scalars, const SurfaceArguments& arguments,
            const OutputArguments& output) {
  part.report.request = step.begin.request;
  part.report.surface = whole_surface(step);
  part.report.colors = step.begin.scalars;
  if (scalars) part.report.color_by = scalars->dataset;
  finish(part, step.mesh, arguments, output);
  if (!step.begin.scalars || output.quiet) return;
  std::cerr << color_accuracy_text(*step.begin.scalars, step.largest_scalar_deviation) << std::endl;
}

}  // namespace multitetra

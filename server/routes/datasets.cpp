// /v1/datasets and /v1/datasets/NAME: the datasets visible to the client.
#include <utility>

#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

// One page. Omits histograms, which are in each dataset's own description.
HttpResponse list_answer(const ResourceRequest& request) {
  std::string_view after;
  for (const auto& [name, value] : request.target.query) {
    if (name == "after") after = value;
  }
  const ClientAccess& access = request.context.service_client->client_access();
  const DatasetPage page = access.list(after);
  std::string text = "{\"datasets\": [";
  const char* separator = "\n";
  for (const DatasetCatalogue::Entry* const entry : page.datasets) {
    text.append(separator).append(entry->json);
    separator = ",\n";
  }
  const Json next = page.next.empty() ? Json() : Json(page.next);
  Json readings = Json::array();
  for (const DatasetReading& one : access.readings()) {
    readings.push_back({{"name", one.name}, {"share", one.share}});
  }
  text.append("\n], \"reading\": ").append(json_text(readings, -1));
  text.append(", \"next\": ").append(json_text(next, -1)).append("}\n");
  return document_answer(std::move(text), request.http);
}

HttpResponse dataset_answer(const ResourceRequest& request) {
  const auto info = request.context.service_client->client_access().describe(request.path[0]);
  if (!info) return request.context.refused(info.error());
  return document_answer(text_of(json_of(*info)), request.http);
}

}  // namespace

Resource dataset_list_resource(const ResourceContext&) {
  return {.name = "datasets",
          .path = "/v1/datasets",
          .answer = [](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return list_answer(request);
          }};
}

Resource dataset_resource(const ResourceContext&) {
  return {.name = "dataset",
          .path = "/v1/datasets/{name}",
          .answer = [](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return dataset_answer(request);
          }};
}

}  // namespace multitetra

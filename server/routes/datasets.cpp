// /v1/datasets and /v1/datasets/NAME: the datasets visible to the client.
#include <utility>

#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

// Omits histograms, which are in each dataset's own description.
HttpResponse list_answer(const ResourceRequest& request) {
  Json list = Json::array();
  for (const DatasetInfo& info : request.context.service_client->client_access().describe()) {
    list.push_back(json_of(info));
    list.back().erase("histogram");
  }
  return document_answer(text_of({{"datasets", std::move(list)}}), request.http);
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

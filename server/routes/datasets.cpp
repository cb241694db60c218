// /v1/datasets and /v1/datasets/NAME: the datasets visible to the client.
#include <utility>

#include "common/base/json.hpp"
#include "common/cli/json_report.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

// Omits histograms, which are in each dataset's own description.
Answer list_answer(const ResourceRequest& request) {
  Json list = Json::array();
  for (const DatasetInfo& info : request.context.caller->permit().describe()) {
    list.push_back(json_of(info));
    list.back().erase("histogram");
  }
  return document_answer(text_of({{"datasets", std::move(list)}}), request.http);
}

Answer dataset_answer(const ResourceRequest& request) {
  const auto info = request.context.caller->permit().describe(request.path[0]);
  if (!info) return request.context.refused(info.error());
  return document_answer(text_of(json_of(*info)), request.http);
}

}  // namespace

Resource dataset_list_resource(const ResourceContext&) {
  return {.name = "datasets",
          .path = "/v1/datasets",
          .answer = [](ResourceRequest request) -> asio::awaitable<Answer> {
            co_return list_answer(request);
          }};
}

Resource dataset_resource(const ResourceContext&) {
  return {.name = "dataset",
          .path = "/v1/datasets/{name}",
          .answer = [](ResourceRequest request) -> asio::awaitable<Answer> {
            co_return dataset_answer(request);
          }};
}

}  // namespace multitetra

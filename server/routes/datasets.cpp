#include "server/routes/datasets.hpp"

#include <utility>

#include "common/base/json.hpp"
#include "common/cli/json_report.hpp"

namespace multitetra {

Answer datasets_answer(const HttpRequest& request, RequestContext& context) {
  Json list = Json::array();
  for (const DatasetInfo& info : context.caller->permit().describe()) {
    list.push_back(json_of(info));
    list.back().erase("histogram");
  }
  return document_answer(text_of({{"datasets", std::move(list)}}), request);
}

Answer dataset_answer(const std::string& dataset, const HttpRequest& request,
                      RequestContext& context) {
  const auto info = context.caller->permit().describe(dataset);
  if (!info) return context.refused(info.error());
  return document_answer(text_of(json_of(*info)), request);
}

}  // namespace multitetra

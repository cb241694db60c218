// /v1/datasets and /v1/datasets/NAME: the datasets visible to the client.
#pragma once

#include <string>

#include "server/http/request_context.hpp"

namespace multitetra {

// The list omits histograms, which are in each dataset's own description.
[[nodiscard]] Answer datasets_answer(const HttpRequest& request, RequestContext& context);
[[nodiscard]] Answer dataset_answer(const std::string& dataset, const HttpRequest& request,
                                    RequestContext& context);

}  // namespace multitetra

// /open/CODE: leads the browser that the server started to its page, once.
#include <string>

#include "server/routes/one_time_link.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {
namespace {

HttpResponse opening_answer(const ResourceContext& context, const ResourceRequest& of) {
  const auto& link = context.options.opening;
  // A browser that looks ahead asks for the head alone.
  const bool is_opened = of.http.method() == http::verb::get;
  const std::string* fragment = link && is_opened ? link->take(of.path.front()) : nullptr;
  if (!fragment) {
    return error_answer(404,
                        {ErrorCode::kInvalidArgument,
                         "This link was used already. Open the address that the server printed."},
                        of.context.request_id);
  }
  HttpResponse response{.status = 303};
  add_field(response, "Location", context.http.base_path + "/" + *fragment);
  add_field(response, "Cache-Control", "no-store");
  return response;
}

}  // namespace

Resource opening_resource(const ResourceContext& context) {
  return {.name = "opening",
          .path = "/open/{code}",
          .kind = Resource::Kind::kFree,
          .answer = [&context](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return opening_answer(context, request);
          }};
}

}  // namespace multitetra

// Passes each request to its resource, after the checks that all have in common.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/request_handler.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {

class Router : public RequestHandler {
 public:
  // The objects that `context` refers to must outlive the router.
  explicit Router(ResourceContext context);

  [[nodiscard]] asio::awaitable<HttpResponse> answer(const HttpRequest& request,
                                                     RequestContext& context) override;
  [[nodiscard]] bool is_probe(std::string_view target) const override;
  [[nodiscard]] std::string loggable(std::string_view target) const override;

 private:
  struct Found {
    const Resource* resource;
    PathValues values;
    std::string token;  // The one in the path; may be empty.
  };
  [[nodiscard]] Found find(const Target& target) const;
  // Returns the answer without the fields that all answers have.
  asio::awaitable<HttpResponse> made(const HttpRequest& request, RequestContext& context);
  // Opens the service for the token of a request. Returns the answer to a request that is refused.
  asio::awaitable<std::optional<HttpResponse>> admit(const HttpRequest& request, const Found& found,
                                                     RequestContext& context);

  const ResourceContext context_;
  const std::vector<Resource> resources_;
};

}  // namespace multitetra

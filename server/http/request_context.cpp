#include "server/http/request_context.hpp"

namespace multitetra {

namespace {

// Returns whether the request's dataset exists but is hidden from the client.
bool is_hidden(const RequestContext& context) {
  if (!context.service_client || !context.record) return false;
  const std::string& dataset = context.record->facts().dataset;
  const CataloguePtr catalogue = context.service_client->catalogue();
  return catalogue && catalogue->find(dataset) &&
         !context.service_client->client_access().rights().may_see(dataset);
}

}  // namespace

HttpResponse RequestContext::refused(const Error& error) {
  if (error.code == ErrorCode::kUnknownDataset && is_hidden(*this)) {
    reason = "Dataset \"" + record->facts().dataset + "\" is not allowed for this token.";
  }
  return error_answer(error, request_id);
}

}  // namespace multitetra

#include "server/http/request_context.hpp"

namespace multitetra {

namespace {

// Returns whether the request's dataset exists but is hidden from the client.
bool is_hidden(const RequestContext& context) {
  if (!context.caller || !context.record) return false;
  const std::string& dataset = context.record->facts().dataset;
  const CataloguePtr catalogue = context.caller->catalogue();
  return catalogue && catalogue->find(dataset) &&
         !context.caller->permit().rights().may_see(dataset);
}

}  // namespace

Answer RequestContext::refused(const Error& error) {
  if (error.code == ErrorCode::kUnknownDataset && is_hidden(*this)) {
    reason = "Dataset \"" + record->facts().dataset + "\" is not allowed for this token.";
  }
  return error_answer(error, request_id);
}

}  // namespace multitetra

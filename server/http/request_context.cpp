#include "server/http/request_context.hpp"

namespace multitetra {

Answer RequestContext::refused(const Error& error) {
  outcome = name(error.code);
  client->admission().observer().error_answered(client->facts(), error, 0);
  return error_answer(error, request_id);
}

}  // namespace multitetra

#include "server/gateway/detail/upstream_queries.hpp"

#include <utility>

#include "server/session/answers.hpp"

namespace multitetra {
namespace {

constexpr int kAttempts = 3;

}  // namespace

asio::awaitable<Result<ServerMessage>> UpstreamQueries::request(
    std::shared_ptr<const UpstreamDataset> dataset, UpstreamClient client, DatasetQuery query) {
  Result<ServerMessage> answer = fail(ErrorCode::kUnavailable, "The client has disconnected.");
  for (int attempt = 0; attempt < kAttempts && !is_closed_; ++attempt) {
    std::function<bool()> is_wanted = [this] { return !is_closed_; };
    const auto reached = co_await upstreams_->reach(dataset, client, is_wanted);
    if (!reached) co_return tl::unexpected(reached.error());
    answer = co_await request_once(reached->link, query);
    if (answer || is_closed_) break;
    upstreams_->report_lost(reached->upstream);
  }
  co_return answer;
}

asio::awaitable<Result<ServerMessage>> UpstreamQueries::request_once(LinkPtr link,
                                                                     DatasetQuery query) {
  if (is_closed_) {
    link->close();
    co_return fail(ErrorCode::kUnavailable, "The client has disconnected.");
  }
  links_.insert(link);
  link->send(std::visit([](const auto& message) { return ClientMessage(message); }, query));
  Result<ServerMessage> answer = co_await link->receive();
  link->close();
  links_.erase(link);
  if (answer && (request_id_of(*answer) != request_id_of(query) || is_shutdown_notice(*answer))) {
    co_return fail(ErrorCode::kUnavailable, "The server is stopping; try again later.");
  }
  co_return answer;
}

void UpstreamQueries::close() {
  is_closed_ = true;
  for (const LinkPtr& link : links_) link->close();
}

}  // namespace multitetra

#include "server/http/one_shot_session.hpp"

#include <algorithm>
#include <utility>

namespace multitetra {
namespace {

tl::unexpected<Error> out_of_place() {
  return fail(ErrorCode::kInternal, "The conversation took an unexpected turn.");
}

}  // namespace

std::uint64_t triangles_of(const StepBegin& step) {
  std::uint64_t sum = 0;
  for (const TileSummary& tile : step.tiles) sum += tile.triangles;
  return sum;
}

OneShotSession::OneShotSession(StreamSessionPtr session, RequestContext& context)
    : session_(std::move(session)), context_(context) {
  context_.session = session_;
}

OneShotSession::~OneShotSession() {
  context_.session = nullptr;
  session_->leave();
}

void OneShotSession::say(const ClientMessage& message) { session_->receive(serialize(message)); }

asio::awaitable<Result<ServerMessage>> OneShotSession::next() {
  auto message = co_await session_->next_message();
  if (!message) co_return fail(ErrorCode::kCancelled, "The conversation was ended.");
  if (const auto* error = std::get_if<ErrorReply>(&*message)) {
    co_return tl::unexpected(error->error);
  }
  if (const auto* end = std::get_if<StreamEnd>(&*message);
      end && end->outcome != StreamOutcome::kComplete) {
    co_return fail(ErrorCode::kUnavailable, "The server stops; ask again later.");
  }
  co_return *std::move(message);
}

template <typename M>
asio::awaitable<Result<M>> OneShotSession::next_a() {
  auto message = co_await next();
  if (!message) co_return tl::unexpected(message.error());
  if (auto* wanted = std::get_if<M>(&*message)) co_return std::move(*wanted);
  co_return out_of_place();
}

asio::awaitable<Result<void>> OneShotSession::greet(std::string token) {
  say(Hello{.token = std::move(token), .agent = "http"});
  const auto welcome = co_await next_a<Welcome>();
  if (!welcome) co_return tl::unexpected(welcome.error());
  co_return Result<void>();
}

asio::awaitable<Result<std::vector<DatasetInfo>>> OneShotSession::datasets() {
  say(ListDatasets{.request_id = 1});
  auto list = co_await next_a<DatasetList>();
  if (!list) co_return tl::unexpected(list.error());
  co_return std::move(list->datasets);
}

asio::awaitable<Result<DatasetInfo>> OneShotSession::dataset(std::string name) {
  auto infos = co_await datasets();
  if (!infos) co_return tl::unexpected(infos.error());
  const auto info = std::find_if(infos->begin(), infos->end(),
                                 [&](const DatasetInfo& one) { return one.name == name; });
  if (info != infos->end()) co_return std::move(*info);
  co_return fail(ErrorCode::kUnknownDataset,
                 "No dataset is named \"" + name + "\"; /v1/datasets tells those that are.");
}

asio::awaitable<Result<EstimateReply>> OneShotSession::estimate(std::string dataset,
                                                                IsosurfaceRequest request) {
  say(Estimate{.request_id = 2, .dataset = std::move(dataset), .request = std::move(request)});
  co_return co_await next_a<EstimateReply>();
}

asio::awaitable<Result<SliceReply>> OneShotSession::slice(std::string dataset, SliceRequest slice) {
  say(Slice{.request_id = 2, .dataset = std::move(dataset), .slice = slice});
  co_return co_await next_a<SliceReply>();
}

asio::awaitable<Result<ProbeReply>> OneShotSession::probe(std::string dataset, ProbeRequest probe) {
  say(Probe{.request_id = 2, .dataset = std::move(dataset), .probe = std::move(probe)});
  co_return co_await next_a<ProbeReply>();
}

asio::awaitable<Result<OneShotSession::Step>> OneShotSession::final_step(
    std::string dataset, IsosurfaceRequest request, std::uint64_t max_triangles,
    std::optional<ScalarRequest> scalars) {
  say(OpenStream{.request_id = ++last_stream_,
                 .dataset = std::move(dataset),
                 .request = std::move(request),
                 .steps = StepPolicy::kFinalOnly,
                 .held = {},
                 .scalars = std::move(scalars)});
  auto begin = co_await next_a<StepBegin>();
  if (!begin) co_return tl::unexpected(begin.error());
  if (const std::uint64_t triangles = triangles_of(*begin); triangles > max_triangles) {
    co_return fail(ErrorCode::kLimitExceeded,
                   "The mesh has " + std::to_string(triangles) +
                       " triangles, and one response holds at most " +
                       std::to_string(max_triangles) +
                       "; allow a larger error, name max_triangles, or take it as a stream.");
  }
  Step step{.begin = *std::move(begin), .payloads = {}, .scalars = {}, .end = {}};
  step.payloads.resize(step.begin.tiles.size());
  if (step.begin.scalars) step.scalars.resize(step.begin.tiles.size());
  for (;;) {
    auto message = co_await next();
    if (!message) co_return tl::unexpected(message.error());
    if (auto* tile = std::get_if<Tile>(&*message)) {
      if (tile->index >= step.payloads.size()) co_return out_of_place();
      step.payloads[tile->index] = std::move(tile->payload);
    } else if (auto* scalars_of_tile = std::get_if<TileScalars>(&*message)) {
      if (scalars_of_tile->index >= step.scalars.size()) co_return out_of_place();
      step.scalars[scalars_of_tile->index] = std::move(scalars_of_tile->codes);
    } else if (const auto* end = std::get_if<StepEnd>(&*message)) {
      step.end = *end;
      const auto last = co_await next_a<StreamEnd>();
      if (!last) co_return tl::unexpected(last.error());
      co_return step;
    } else {
      co_return out_of_place();
    }
  }
}

}  // namespace multitetra

#include "server/session/session.hpp"

#include <algorithm>
#include <utility>

#include "common/request/lattice_limit.hpp"

namespace multitetra {
namespace {

Action reply(Error error, std::uint64_t request_id = 0) {
  return Send{ErrorReply{.request_id = request_id, .error = std::move(error)}};
}

// What forbids a stream whatever the dataset.
Result<void> check_stream(const OpenStream& open, std::uint64_t last_request_id,
                          std::size_t max_held_digests) {
  if (open.request_id <= last_request_id) {
    return fail(ErrorCode::kInvalidArgument,
                "The request id is " + std::to_string(open.request_id) +
                    "; it must be greater than " + std::to_string(last_request_id) +
                    ", that of the last stream on this connection.");
  }
  if (open.held.size() > max_held_digests) {
    return fail(ErrorCode::kLimitExceeded, "The request names " + std::to_string(open.held.size()) +
                                               " held tiles; at most " +
                                               std::to_string(max_held_digests) + " are allowed.");
  }
  const auto request = validated(open.request);
  if (!request) return tl::unexpected(request.error());
  return {};
}

// Previews that no stream of this dataset can have begun with.
Result<void> check_begun(const std::vector<Preview>& begun, const DatasetInfo& info) {
  if (begun.empty() || begun.front().finest_spacing <= 1 << info.grid_exponent) return {};
  return fail(ErrorCode::kInvalidArgument,
              "OpenStream.begun names a preview with a finest spacing of " +
                  std::to_string(begun.front().finest_spacing) + "; dataset \"" + info.name +
                  "\" has a grid of " + std::to_string(1 << info.grid_exponent) + " steps a side.");
}

std::string version_range(std::uint32_t low, std::uint32_t high) {
  return low == high ? std::to_string(low) : std::to_string(low) + " to " + std::to_string(high);
}

}  // namespace

Result<void> check_limits(const SessionOptions& options, const IsosurfaceRequest& request) {
  const std::size_t regions = request.thresholds.regions.size();
  if (regions <= options.max_regions) return {};
  return fail(ErrorCode::kLimitExceeded, "The threshold map has " + std::to_string(regions) +
                                             " regions; this server allows " +
                                             std::to_string(options.max_regions) + ".");
}

Session::Session(CataloguePtr catalogue, SessionOptions options, AccessListPtr access,
                 LatestCatalogue latest)
    : catalogue_(std::move(catalogue)),
      latest_(std::move(latest)),
      options_(std::move(options)),
      access_(std::move(access)) {}

Actions Session::renew(AccessListPtr access) {
  access_ = std::move(access);
  if (!is_welcomed_ || is_closed_ || !access_) return {};
  auto rights = access_->rights_of(token_);
  if (!rights) return end(rights.error());
  rights_ = *std::move(rights);
  return {};
}

Actions Session::receive(const ClientMessage& message) {
  if (is_closed_) return {};
  if (!is_welcomed_ && !std::holds_alternative<Hello>(message)) {
    return end({ErrorCode::kUnexpectedMessage, "The first message must be Hello."});
  }
  return std::visit([this](const auto& m) { return answer(m); }, message);
}

Actions Session::receive(const ParseError& error) {
  if (is_closed_) return {};
  if (!is_welcomed_ || error.error.code == ErrorCode::kMalformedMessage) return end(error.error);
  return {reply(error.error, error.request_id)};
}

Actions Session::end(const Error& error) {
  if (is_closed_) return {};
  Actions actions;
  if (running_) actions.push_back(StopStream{*running_, StreamOutcome::kCancelled});
  running_.reset();
  is_closed_ = true;
  actions.push_back(reply(error));
  actions.push_back(Close{error.text});
  return actions;
}

void Session::stream_ended(std::uint64_t request_id) {
  if (running_ == request_id) running_.reset();
}

Actions Session::answer(const Hello& hello) {
  if (is_welcomed_) {
    return {reply({ErrorCode::kUnexpectedMessage,
                   "Hello was said already; it opens a connection and comes once."})};
  }
  if (hello.min_version > kProtocolVersion || hello.max_version < kProtocolVersion) {
    return end({ErrorCode::kUnsupportedVersion,
                "The client speaks protocol version " +
                    version_range(hello.min_version, hello.max_version) + ", this server version " +
                    std::to_string(kProtocolVersion) + "."});
  }
  if (std::find(hello.codecs.begin(), hello.codecs.end(), PayloadCodec::kDracoLattice) ==
      hello.codecs.end()) {
    return end({ErrorCode::kInvalidArgument,
                "The client names no codec of this server; it must know Draco on the lattice "
                "(codec 1)."});
  }
  if (access_) {
    auto rights = access_->rights_of(hello.token);
    if (!rights) return end(rights.error());
    rights_ = *std::move(rights);
    token_ = hello.token;
  }
  is_welcomed_ = true;
  return {Send{Welcome{.version = kProtocolVersion,
                       .codec = PayloadCodec::kDracoLattice,
                       .agent = options_.agent,
                       .max_message_bytes = options_.max_message_bytes}}};
}

Actions Session::answer(const ListDatasets& list) {
  if (latest_) catalogue_ = latest_();
  std::vector<DatasetInfo> infos = catalogue_->infos();
  std::erase_if(infos, [this](const DatasetInfo& info) { return !rights_.may_see(info.name); });
  return {Send{DatasetList{.request_id = list.request_id, .datasets = std::move(infos)}}};
}

Result<std::shared_ptr<const StepSource>> Session::source_of(const std::string& dataset) const {
  if (no_work_) return tl::unexpected(*no_work_);
  // What a client may not see does not exist for it.
  std::shared_ptr<const StepSource> source =
      rights_.may_see(dataset) ? catalogue_->find(dataset) : nullptr;
  if (!source) {
    return fail(ErrorCode::kUnknownDataset,
                "No dataset is named \"" + dataset +
                    "\"; the list of datasets (multitetra-client list, /v1/datasets) tells those "
                    "that are.");
  }
  return source;
}

Result<std::shared_ptr<const StepSource>> Session::source_of(
    const std::string& dataset, const IsosurfaceRequest& request) const {
  if (const auto checked = check_limits(options_, request); !checked) {
    return tl::unexpected(checked.error());
  }
  auto source = source_of(dataset);
  if (!source) return source;
  if (const auto checked = check_lattice(request, (*source)->info()); !checked) {
    return tl::unexpected(checked.error());
  }
  if (request.cell) {
    if (const auto checked = check_cell(*request.cell, (*source)->info()); !checked) {
      return tl::unexpected(checked.error());
    }
  }
  return source;
}

Result<std::shared_ptr<const StepSource>> Session::field_for(const ScalarRequest& scalars,
                                                             const DatasetInfo& surface) const {
  if (const auto valid = validated(scalars); !valid) return tl::unexpected(valid.error());
  auto field = source_of(scalars.dataset);
  if (!field) return field;
  if (const auto checked = check_same_world(surface, (*field)->info()); !checked) {
    return tl::unexpected(checked.error());
  }
  return field;
}

Actions Session::answer(const OpenStream& open) {
  if (const auto checked = check_stream(open, last_request_id_, options_.max_held_digests);
      !checked) {
    return {reply(checked.error(), open.request_id)};
  }
  auto found = source_of(open.dataset, open.request);
  if (!found) return {reply(found.error(), open.request_id)};
  if (const auto checked = check_begun(open.begun, (*found)->info()); !checked) {
    return {reply(checked.error(), open.request_id)};
  }
  std::shared_ptr<const StepSource> scalars;
  if (open.scalars) {
    auto field = field_for(*open.scalars, (*found)->info());
    if (!field) return {reply(field.error(), open.request_id)};
    scalars = *std::move(field);
  }
  Actions actions;
  if (running_) actions.push_back(StopStream{*running_, StreamOutcome::kSuperseded});
  last_request_id_ = open.request_id;
  running_ = open.request_id;
  actions.push_back(StartStream{open, *std::move(found), std::move(scalars)});
  return actions;
}

// A Cancel that crosses the end of its stream on the wire is no mistake, so it has no answer.
Actions Session::answer(const Cancel& cancel) {
  if (running_ != cancel.request_id) return {};
  running_.reset();
  return {StopStream{cancel.request_id, StreamOutcome::kCancelled}};
}

Actions Session::answer(const Ping& ping) { return {Send{Pong{.value = ping.value}}}; }

Actions Session::answer(const Estimate& estimate) {
  if (const auto request = validated(estimate.request); !request) {
    return {reply(request.error(), estimate.request_id)};
  }
  return ask(estimate, source_of(estimate.dataset, estimate.request));
}

Actions Session::answer(const Slice& slice) {
  if (const auto plane = validated(slice.slice); !plane) {
    return {reply(plane.error(), slice.request_id)};
  }
  return ask(slice, source_of(slice.dataset));
}

Actions Session::answer(const Probe& probe) {
  if (const auto places = validated(probe.probe); !places) {
    return {reply(places.error(), probe.request_id)};
  }
  return ask(probe, source_of(probe.dataset));
}

Actions Session::ask(Question question, Result<std::shared_ptr<const StepSource>> source) {
  const std::uint64_t request_id = request_id_of(question);
  if (!source) return {reply(source.error(), request_id)};
  if (questions_ >= options_.max_questions) {
    return {reply({ErrorCode::kLimitExceeded,
                   "There are " + std::to_string(questions_) +
                       " questions (estimates, slices, probes) under way on this connection; wait "
                       "for one of their answers."},
                  request_id)};
  }
  ++questions_;
  return {AnswerQuestion{std::move(question), *std::move(source)}};
}

}  // namespace multitetra

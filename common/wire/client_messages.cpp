// Messages from the client to the server.
#include <bit>
#include <tuple>

#include "common/wire/detail/wire_bytes.hpp"
#include "common/wire/detail/wire_codecs.hpp"
#include "common/wire/detail/wire_request.hpp"
#include "common/wire/detail/wire_samples.hpp"
#include "common/wire/detail/wire_scalars.hpp"
#include "common/wire/messages.hpp"
#include "multitetra/v1/conversation.pb.h"

namespace multitetra {
namespace {

using namespace wire;

constexpr std::size_t kMaxTokenBytes = 4096;
constexpr std::size_t kMaxBehalfBytes = 512;
constexpr std::size_t kDigestBytes = 16;

// A digest has 16 bytes: high then low, little-endian.
void append_u64(std::uint64_t value, std::string& bytes) {
  for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
}

std::uint64_t u64_at(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 8; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::vector<ContentDigest> read_tile_digests(std::string_view bytes, FieldChecks& checks) {
  checks.require(bytes.size() % kDigestBytes == 0, "OpenStream.cached_tile_digests",
                 "must have 16 bytes for each digest.");
  checks.at_most("OpenStream.cached_tile_digests", bytes.size() / kDigestBytes, kMaxHeldDigests,
                 "digests");
  std::vector<ContentDigest> held;
  if (checks.first()) return held;
  held.reserve(bytes.size() / kDigestBytes);
  for (; !bytes.empty(); bytes.remove_prefix(kDigestBytes)) {
    held.push_back({u64_at(bytes), u64_at(bytes.substr(8))});
  }
  return held;
}

bool is_preview_below(const Preview& preview, std::int32_t coarser) {
  const std::int32_t least = preview.is_unsimplified || preview.shell ? 1 : 2;
  const std::int32_t finest = preview.finest_spacing;
  return finest >= least && finest < coarser &&
         std::has_single_bit(static_cast<std::uint32_t>(finest));
}

std::vector<Preview> read_resumed_previews(
    const google::protobuf::RepeatedPtrField<v1::Preview>& wire, FieldChecks& checks) {
  checks.at_most("OpenStream.resumed_previews", static_cast<std::size_t>(wire.size()), kMaxPreviews,
                 "previews");
  std::vector<Preview> begun;
  std::int32_t coarser = 2 * kMaxPreviewSpacing;
  for (const v1::Preview& preview : wire) {
    Preview next{.finest_spacing = static_cast<std::int32_t>(preview.finest_spacing()),
                 .is_unsimplified = preview.is_unsimplified()};
    if (preview.has_shell()) {
      next.shell = read_shell_step("OpenStream.resumed_previews.shell", preview.shell(), checks);
    }
    checks.require(is_preview_below(next, coarser), "OpenStream.resumed_previews.finest_spacing",
                   "must be a power of two from 2 (1 of an unsimplified one and of shells) to "
                   "2^19, each less than the previous one.");
    coarser = next.finest_spacing;
    begun.push_back(next);
    if (checks.first()) return {};
  }
  return begun;
}

void write(const Hello& hello, v1::ClientMessage& message) {
  v1::Hello& wire = *message.mutable_hello();
  wire.set_min_version(hello.min_version);
  wire.set_max_version(hello.max_version);
  for (const PayloadCodec codec : hello.codecs) wire.add_codecs(to_wire<v1::PayloadCodec>(codec));
  wire.set_token(hello.token);
  wire.set_agent(hello.agent);
  wire.set_on_behalf_of(hello.on_behalf_of);
  wire.set_client_address(hello.client_address);
}

Hello read(const v1::Hello& wire, FieldChecks& checks) {
  Hello hello;
  hello.min_version = wire.min_version() == 0 ? kProtocolVersion : wire.min_version();
  hello.max_version = wire.max_version() == 0 ? hello.min_version : wire.max_version();
  checks.integer("Hello.max_version", hello.max_version, hello.min_version, kMaxU32);
  if (!wire.codecs().empty()) {
    hello.codecs = known_codecs(wire.codecs());
    checks.require(has_draco(hello.codecs), "Hello.codecs",
                   "must include 1 (Draco lattice), which every client must decode.");
  }
  checks.at_most("Hello.token", wire.token().size(), kMaxTokenBytes, "bytes");
  checks.at_most("Hello.agent", wire.agent().size(), kMaxNameBytes, "bytes");
  checks.at_most("Hello.on_behalf_of", wire.on_behalf_of().size(), kMaxBehalfBytes, "bytes");
  checks.at_most("Hello.client_address", wire.client_address().size(), kMaxNameBytes, "bytes");
  hello.token = wire.token();
  hello.agent = wire.agent();
  hello.on_behalf_of = wire.on_behalf_of();
  hello.client_address = wire.client_address();
  return hello;
}

void write(const ListDatasets& list, v1::ClientMessage& message) {
  v1::ListDatasets& wire = *message.mutable_list_datasets();
  wire.set_request_id(list.request_id);
  wire.set_in_pages(list.in_pages);
  wire.set_after(list.after);
}

ListDatasets read(const v1::ListDatasets& wire, FieldChecks& checks) {
  checks.at_most("ListDatasets.after", wire.after().size(), kMaxNameBytes, "bytes");
  return {.request_id = wire.request_id(), .in_pages = wire.in_pages(), .after = wire.after()};
}

void write(const OpenStream& open, v1::ClientMessage& message) {
  v1::OpenStream& wire = *message.mutable_open_stream();
  wire.set_request_id(open.request_id);
  wire.set_dataset(open.dataset);
  write_request(open.request, *wire.mutable_request());
  wire.set_steps(to_wire<v1::StepPolicy>(open.steps));
  wire.mutable_cached_tile_digests()->reserve(open.cached_tile_digests.size() * kDigestBytes);
  for (const ContentDigest& digest : open.cached_tile_digests) {
    append_u64(digest.high, *wire.mutable_cached_tile_digests());
    append_u64(digest.low, *wire.mutable_cached_tile_digests());
  }
  for (const Preview& preview : open.resumed_previews) {
    v1::Preview& begun = *wire.add_resumed_previews();
    begun.set_finest_spacing(static_cast<std::uint32_t>(preview.finest_spacing));
    begun.set_is_unsimplified(preview.is_unsimplified);
    if (preview.shell) write_shell_step(*preview.shell, *begun.mutable_shell());
  }
  if (open.priority != Priority::kNormal) {
    wire.set_priority(to_wire<v1::Priority>(open.priority));
  }
  if (open.scalars) wire::write(*open.scalars, *wire.mutable_scalars());
  wire.set_triangles_per_second(open.triangles_per_second);
  if (open.use != MeshUse::kKeep) wire.set_use(to_wire<v1::MeshUse>(open.use));
  wire.set_drawable_triangles(open.drawable_triangles);
  for (const std::string& dataset : open.further_datasets) wire.add_further_datasets(dataset);
  wire.set_content_id(open.content_id);
}

void read_further_datasets(const v1::OpenStream& wire, OpenStream& open, FieldChecks& checks) {
  if (wire.further_datasets().empty()) return;
  constexpr const char* kField = "OpenStream.further_datasets";
  const bool is_one_preview =
      open.steps == StepPolicy::kPreviewsOnly && open.resumed_previews.size() == 1 &&
      open.cached_tile_digests.empty() && !open.scalars && !open.request.cell;
  checks.require(is_one_preview, kField,
                 "require STEP_POLICY_PREVIEWS_ONLY and one of resumed_previews, without cached "
                 "digests, scalars and cell.");
  if (checks.first()) return;
  for (const std::string& dataset : wire.further_datasets()) checks.dataset_name(kField, dataset);
  open.further_datasets.assign(wire.further_datasets().begin(), wire.further_datasets().end());
}

OpenStream read(const v1::OpenStream& wire, FieldChecks& checks) {
  OpenStream open;
  checks.integer("OpenStream.request_id", wire.request_id(), 1);
  checks.dataset_name("OpenStream.dataset", wire.dataset());
  open.request_id = wire.request_id();
  open.dataset = wire.dataset();
  open.request = read_request(wire.request(), checks);
  open.steps = checks.enumerator<StepPolicy>("OpenStream.steps", wire.steps(),
                                             StepPolicy::kPreviewsOnly, StepPolicy::kProgressive);
  open.cached_tile_digests = read_tile_digests(wire.cached_tile_digests(), checks);
  open.resumed_previews = read_resumed_previews(wire.resumed_previews(), checks);
  open.priority = checks.enumerator<Priority>("OpenStream.priority", wire.priority(),
                                              Priority::kBackground, Priority::kNormal);
  if (wire.has_scalars()) open.scalars = wire::read(wire.scalars(), checks);
  checks.not_negative("OpenStream.triangles_per_second", wire.triangles_per_second());
  open.triangles_per_second = wire.triangles_per_second();
  open.use =
      checks.enumerator<MeshUse>("OpenStream.use", wire.use(), MeshUse::kDisplay, MeshUse::kKeep);
  open.drawable_triangles = wire.drawable_triangles();
  read_further_datasets(wire, open, checks);
  open.content_id = wire.content_id();
  return open;
}

void write(const Cancel& cancel, v1::ClientMessage& message) {
  message.mutable_cancel()->set_request_id(cancel.request_id);
}

void write(const Ping& ping, v1::ClientMessage& message) {
  message.mutable_ping()->set_value(ping.value);
}

void write(const Estimate& estimate, v1::ClientMessage& message) {
  v1::Estimate& wire = *message.mutable_estimate();
  wire.set_request_id(estimate.request_id);
  wire.set_dataset(estimate.dataset);
  write_request(estimate.request, *wire.mutable_request());
  if (estimate.priority != Priority::kNormal) {
    wire.set_priority(to_wire<v1::Priority>(estimate.priority));
  }
  wire.set_content_id(estimate.content_id);
}

Estimate read(const v1::Estimate& wire, FieldChecks& checks) {
  checks.dataset_name("Estimate.dataset", wire.dataset());
  return {.request_id = wire.request_id(),
          .dataset = wire.dataset(),
          .request = read_request(wire.request(), checks),
          .priority = checks.enumerator<Priority>("Estimate.priority", wire.priority(),
                                                  Priority::kBackground, Priority::kNormal),
          .content_id = wire.content_id()};
}

void write(const Slice& slice, v1::ClientMessage& message) {
  wire::write(slice, *message.mutable_slice());
}

void write(const Probe& probe, v1::ClientMessage& message) {
  wire::write(probe, *message.mutable_probe());
}

// Counts regions and datasets before the parser allocates memory for them. The error still has the
// request's id, so the connection remains open.
std::optional<ParseError> too_many_entries(std::string_view bytes) {
  constexpr int kOpen = v1::ClientMessage::kOpenStreamFieldNumber;
  FieldChecks of_datasets;
  of_datasets.at_most("OpenStream.further_datasets",
                      count_entries(bytes, {kOpen, v1::OpenStream::kFurtherDatasetsFieldNumber}),
                      kMaxFurtherDatasets, "datasets");
  if (of_datasets.first()) {
    return ParseError{*of_datasets.first(),
                      last_number(bytes, {kOpen, v1::OpenStream::kRequestIdFieldNumber})};
  }
  for (const auto& [kind, request, id] :
       {std::tuple<int, int, int>(kOpen, v1::OpenStream::kRequestFieldNumber,
                                  v1::OpenStream::kRequestIdFieldNumber),
        {v1::ClientMessage::kEstimateFieldNumber, v1::Estimate::kRequestFieldNumber,
         v1::Estimate::kRequestIdFieldNumber}}) {
    FieldChecks checks;
    checks.at_most(
        "IsosurfaceRequest.threshold.regions",
        count_entries(bytes, {kind, request, v1::IsosurfaceRequest::kThresholdFieldNumber,
                              v1::ThresholdMap::kRegionsFieldNumber}),
        kMaxThresholdRegions, "regions");
    if (checks.first()) return ParseError{*checks.first(), last_number(bytes, {kind, id})};
  }
  return std::nullopt;
}

}  // namespace

std::string serialize(const ClientMessage& message) {
  v1::ClientMessage bytes;
  std::visit([&bytes](const auto& alternative) { write(alternative, bytes); }, message);
  return bytes.SerializeAsString();
}

bool record_started_step(const StepBegin& step, OpenStream& open) {
  std::vector<Preview>& begun = open.resumed_previews;
  if (!open.further_datasets.empty()) return true;  // It names its preview already.
  if (step.step < begun.size()) return true;        // A resumed preview, sent again.
  if (step.is_final && !step.shell) {
    open.steps = StepPolicy::kFinalOnly;
  } else if (begun.size() < kMaxPreviews) {
    const Preview preview{.finest_spacing = step.finest_spacing,
                          .is_unsimplified = step.is_unsimplified,
                          .shell = step.shell};
    const std::int32_t coarser =
        begun.empty() ? 2 * kMaxPreviewSpacing : begun.back().finest_spacing;
    if (!is_preview_below(preview, coarser)) return false;
    begun.push_back(preview);
  }
  return true;
}

tl::expected<ClientMessage, ParseError> parse_client_message(std::string_view bytes) {
  if (auto excess = too_many_entries(bytes)) return tl::unexpected(*std::move(excess));
  v1::ClientMessage wire;
  if (!parse(bytes, wire)) {
    return refuse(ErrorCode::kMalformedMessage, not_a_message("ClientMessage", bytes.size()));
  }
  FieldChecks checks;
  const auto checked = [&checks](ClientMessage message, std::uint64_t request_id) {
    return outcome(std::move(message), checks, request_id);
  };
  switch (wire.kind_case()) {
    case v1::ClientMessage::kHello:
      return checked(read(wire.hello(), checks), 0);
    case v1::ClientMessage::kListDatasets:
      return checked(read(wire.list_datasets(), checks), wire.list_datasets().request_id());
    case v1::ClientMessage::kOpenStream:
      return checked(read(wire.open_stream(), checks), wire.open_stream().request_id());
    case v1::ClientMessage::kCancel:
      return Cancel{wire.cancel().request_id()};
    case v1::ClientMessage::kPing:
      return Ping{wire.ping().value()};
    case v1::ClientMessage::kEstimate:
      return checked(read(wire.estimate(), checks), wire.estimate().request_id());
    case v1::ClientMessage::kSlice:
      return checked(wire::read(wire.slice(), checks), wire.slice().request_id());
    case v1::ClientMessage::kProbe:
      return checked(wire::read(wire.probe(), checks), wire.probe().request_id());
    case v1::ClientMessage::KIND_NOT_SET:
      break;
  }
  return refuse(ErrorCode::kMalformedMessage,
                "A ClientMessage has an unknown kind; valid kinds: hello, list_datasets, "
                "open_stream, cancel, ping, estimate, slice, probe.");
}

}  // namespace multitetra

// Messages from the server to the client.
#include <algorithm>
#include <bit>
#include <cmath>

#include "common/base/natural_order.hpp"
#include "common/base/printable_line.hpp"
#include "common/base/utf8.hpp"
#include "common/net/frame.hpp"
#include "common/wire/detail/wire_bytes.hpp"
#include "common/wire/detail/wire_codecs.hpp"
#include "common/wire/detail/wire_dataset.hpp"
#include "common/wire/detail/wire_request.hpp"
#include "common/wire/detail/wire_samples.hpp"
#include "common/wire/detail/wire_scalars.hpp"
#include "common/wire/messages.hpp"
#include "multitetra/v1/conversation.pb.h"

namespace multitetra {
namespace {

using namespace wire;

constexpr std::size_t kMaxTilesPerStep = 262144;

static_assert(static_cast<int>(ErrorCode::kPermissionDenied) == v1::ERROR_CODE_PERMISSION_DENIED &&
                  v1::ErrorCode_MAX == v1::ERROR_CODE_PERMISSION_DENIED,
              "Error codes have the same numbers in common/base/result.hpp and on the wire.");

// Error texts may quote external text (file names, library messages), but the wire requires UTF-8.
std::string as_utf8(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_sequence(text);
    result += length == 0 ? std::string_view("?") : text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

void write(const TileSummary& tile, v1::TileSummary& wire) {
  wire.set_cube_exponent(static_cast<std::uint32_t>(tile.cube.exponent));
  wire.set_cube_x(static_cast<std::uint32_t>(tile.cube.x));
  wire.set_cube_y(static_cast<std::uint32_t>(tile.cube.y));
  wire.set_cube_z(static_cast<std::uint32_t>(tile.cube.z));
  wire.set_digest_high(tile.digest.high);
  wire.set_digest_low(tile.digest.low);
  wire.set_triangles(tile.triangles);
  wire.set_vertices(tile.vertices);
  wire.set_bytes(tile.bytes);
  wire.set_simplification_bound_world(tile.simplification_bound);
}

TileSummary read(const v1::TileSummary& wire, FieldChecks& checks) {
  checks.integer("TileSummary.cube_exponent", wire.cube_exponent(), 0, kMaxLatticeBits);
  const std::uint32_t exponent = std::min<std::uint32_t>(wire.cube_exponent(), kMaxLatticeBits);
  const std::uint64_t last_position = (std::uint64_t{1} << (kMaxLatticeBits - exponent)) - 1;
  checks.integer("TileSummary.cube_x", wire.cube_x(), 0, last_position);
  checks.integer("TileSummary.cube_y", wire.cube_y(), 0, last_position);
  checks.integer("TileSummary.cube_z", wire.cube_z(), 0, last_position);
  checks.integer("TileSummary.triangles", wire.triangles(), 1, kMaxTileTriangles);
  checks.integer("TileSummary.vertices", wire.vertices(), 3, 3 * std::uint64_t{wire.triangles()});
  checks.integer("TileSummary.bytes", wire.bytes(), 1, kMaxServerFrameBytes);
  checks.not_negative("TileSummary.simplification_bound_world", wire.simplification_bound_world());
  return {
      .cube = {static_cast<std::int32_t>(exponent), static_cast<std::int32_t>(wire.cube_x()),
               static_cast<std::int32_t>(wire.cube_y()), static_cast<std::int32_t>(wire.cube_z())},
      .digest = {wire.digest_high(), wire.digest_low()},
      .triangles = wire.triangles(),
      .vertices = wire.vertices(),
      .bytes = wire.bytes(),
      .simplification_bound = wire.simplification_bound_world()};
}

void write(const Welcome& welcome, v1::ServerMessage& message) {
  v1::Welcome& wire = *message.mutable_welcome();
  wire.set_version(welcome.version);
  for (const PayloadCodec codec : welcome.codecs) {
    wire.add_codecs(to_wire<v1::PayloadCodec>(codec));
  }
  wire.set_agent(welcome.agent);
  wire.set_max_message_bytes(welcome.max_message_bytes);
}

Welcome read(const v1::Welcome& wire, FieldChecks& checks) {
  checks.integer("Welcome.version", wire.version(), 1, kMaxU32);
  checks.at_most("Welcome.agent", wire.agent().size(), kMaxNameBytes, "bytes");
  Welcome welcome{.version = wire.version(),
                  .agent = wire.agent(),
                  .max_message_bytes = wire.max_message_bytes()};
  if (!wire.codecs().empty()) welcome.codecs = known_codecs(wire.codecs());
  checks.require(has_draco(welcome.codecs), "Welcome.codecs", "must include 1 (Draco lattice).");
  return welcome;
}

void write(const DatasetList& list, v1::ServerMessage& message) {
  v1::DatasetList& wire = *message.mutable_dataset_list();
  wire.set_request_id(list.request_id);
  wire.set_next(list.next);
  for (const DatasetInfo& info : list.datasets) write_dataset(info, *wire.add_datasets());
}

// Appends a field of type message, given its bytes.
void append_message(std::string& bytes, int field, std::string_view content) {
  constexpr unsigned kLengthDelimited = 2;
  const auto append_number = [&bytes](std::size_t number) {
    for (; number >= 0x80; number >>= 7) bytes += static_cast<char>(number | 0x80);
    bytes += static_cast<char>(number);
  };
  append_number(static_cast<unsigned>(field) << 3 | kLengthDelimited);
  append_number(content.size());
  bytes += content;
}

// Appends the datasets that are encoded already: a page costs no more than copying its bytes.
std::string serialize_encoded(const DatasetList& list) {
  v1::ServerMessage message;
  write(list, message);
  std::string content = message.dataset_list().SerializeAsString();
  for (const auto& dataset : list.encoded) {
    append_message(content, v1::DatasetList::kDatasetsFieldNumber, *dataset);
  }
  std::string bytes;
  append_message(bytes, v1::ServerMessage::kDatasetListFieldNumber, content);
  return bytes;
}

DatasetList read(const v1::DatasetList& wire, FieldChecks& checks) {
  checks.at_most("DatasetList.next", wire.next().size(), kMaxNameBytes, "bytes");
  DatasetList list{.request_id = wire.request_id(), .next = wire.next()};
  for (const v1::DatasetInfo& info : wire.datasets()) {
    list.datasets.push_back(read_dataset(info, checks));
    if (checks.first()) break;
  }
  return list;
}

void write(const StepBegin& begin, v1::ServerMessage& message) {
  v1::StepBegin& wire = *message.mutable_step_begin();
  wire.set_request_id(begin.request_id);
  wire.set_step(begin.step);
  wire.set_is_final(begin.is_final);
  write_request(begin.request, *wire.mutable_request());
  wire.set_error_bound_world(begin.error_bound_world);
  wire.set_finest_spacing(static_cast<std::uint32_t>(begin.finest_spacing));
  wire.set_codec(begin.shell ? v1::PAYLOAD_CODEC_SAMPLE_SHELL : v1::PAYLOAD_CODEC_DRACO_LATTICE);
  if (begin.shell) write_shell_step(*begin.shell, *wire.mutable_shell());
  wire.set_is_unsimplified(begin.is_unsimplified);
  wire.set_crossed_octants(begin.crossed_octants);
  if (begin.scalars) wire::write(*begin.scalars, *wire.mutable_scalars());
  wire.set_tetrahedra(begin.tetrahedra);
  wire.set_active_tetrahedra(begin.active_tetrahedra);
  wire.mutable_tiles()->Reserve(static_cast<int>(begin.tiles.size()));
  for (const TileSummary& tile : begin.tiles) write(tile, *wire.add_tiles());
}

StepBegin read(const v1::StepBegin& wire, FieldChecks& checks) {
  StepBegin begin;
  checks.integer("StepBegin.request_id", wire.request_id(), 1);
  begin.request_id = wire.request_id();
  begin.step = wire.step();
  begin.is_final = wire.is_final();
  begin.request = read_request(wire.request(), checks);
  checks.not_negative("StepBegin.error_bound_world", wire.error_bound_world());
  begin.error_bound_world = wire.error_bound_world();
  const std::uint32_t spacing = std::max<std::uint32_t>(wire.finest_spacing(), 1);
  checks.require(std::has_single_bit(spacing) && spacing <= kMaxGridSteps,
                 "StepBegin.finest_spacing", "must be a power of two from 1 to 2^19.");
  begin.finest_spacing = static_cast<std::int32_t>(spacing);
  const auto codec = checks.enumerator<PayloadCodec>(
      "StepBegin.codec", wire.codec(), PayloadCodec::kSampleShell, PayloadCodec::kDracoLattice);
  checks.require(wire.has_shell() == (codec == PayloadCodec::kSampleShell), "StepBegin.shell",
                 "must be set exactly where the codec is 2 (sample shells).");
  if (wire.has_shell()) begin.shell = read_shell_step("StepBegin.shell", wire.shell(), checks);
  checks.integer("StepBegin.active_tetrahedra", wire.active_tetrahedra(), 0, wire.tetrahedra());
  checks.require(!wire.is_unsimplified() || !wire.is_final(), "StepBegin.is_unsimplified",
                 "must be absent in a final step.");
  checks.require(!wire.is_unsimplified() || !wire.has_shell(), "StepBegin.is_unsimplified",
                 "must be absent with sample shells, which are never simplified.");
  begin.is_unsimplified = wire.is_unsimplified();
  checks.integer("StepBegin.crossed_octants", wire.crossed_octants(), 0, 0xFF);
  begin.crossed_octants = wire.crossed_octants();
  if (wire.has_scalars()) begin.scalars = wire::read(wire.scalars(), checks);
  begin.tetrahedra = wire.tetrahedra();
  begin.active_tetrahedra = wire.active_tetrahedra();
  begin.tiles.reserve(static_cast<std::size_t>(wire.tiles_size()));
  for (const v1::TileSummary& tile : wire.tiles()) begin.tiles.push_back(read(tile, checks));
  return begin;
}

void write(const Tile& tile, v1::ServerMessage& message) {
  v1::Tile& wire = *message.mutable_tile();
  wire.set_request_id(tile.request_id);
  wire.set_step(tile.step);
  wire.set_index(tile.index);
  if (tile.payload) wire.set_payload(*tile.payload);
}

Tile read(v1::Tile& wire, FieldChecks& checks) {
  checks.integer("Tile.request_id", wire.request_id(), 1);
  checks.require(!wire.payload().empty(), "Tile.payload",
                 "is empty; it must have at least 1 byte.");
  return {.request_id = wire.request_id(),
          .step = wire.step(),
          .index = wire.index(),
          .payload = std::make_shared<const std::string>(std::move(*wire.mutable_payload()))};
}

void write(const StepEnd& end, v1::ServerMessage& message) {
  v1::StepEnd& wire = *message.mutable_step_end();
  wire.set_request_id(end.request_id);
  wire.set_step(end.step);
  wire.set_tiles_sent(end.tiles_sent);
  wire.set_payload_bytes(end.payload_bytes);
  wire.set_digest_high(end.digest.high);
  wire.set_digest_low(end.digest.low);
  wire.set_seconds(end.seconds);
}

StepEnd read(const v1::StepEnd& wire, FieldChecks& checks) {
  checks.integer("StepEnd.request_id", wire.request_id(), 1);
  checks.not_negative("StepEnd.seconds", wire.seconds());
  return {.request_id = wire.request_id(),
          .step = wire.step(),
          .tiles_sent = wire.tiles_sent(),
          .payload_bytes = wire.payload_bytes(),
          .digest = {wire.digest_high(), wire.digest_low()},
          .seconds = wire.seconds()};
}

void write(const StreamEnd& end, v1::ServerMessage& message) {
  v1::StreamEnd& wire = *message.mutable_stream_end();
  wire.set_request_id(end.request_id);
  wire.set_outcome(to_wire<v1::StreamOutcome>(end.outcome));
  wire.set_steps(end.steps);
}

StreamEnd read(const v1::StreamEnd& wire, FieldChecks& checks) {
  checks.integer("StreamEnd.request_id", wire.request_id(), 1);
  return {.request_id = wire.request_id(),
          .outcome = checks.enumerator<StreamOutcome>("StreamEnd.outcome", wire.outcome(),
                                                      StreamOutcome::kSuperseded, {}),
          .steps = wire.steps()};
}

void write(const ErrorReply& reply, v1::ServerMessage& message) {
  v1::ErrorReply& wire = *message.mutable_error();
  wire.set_request_id(reply.request_id);
  wire.set_code(static_cast<v1::ErrorCode>(reply.error.code));
  wire.set_text(as_utf8(reply.error.text));
  wire.set_retry_after(reply.error.retry_after);
}

// Never fails, as there is no fallback for an error reply: replaces invalid fields by defaults. The
// text is one line without control characters.
ErrorReply read(const v1::ErrorReply& wire) {
  constexpr std::size_t kMaxText = 1000;
  const bool known = v1::ErrorCode_IsValid(wire.code());
  const bool has_retry_after = std::isfinite(wire.retry_after()) && wire.retry_after() > 0;
  return {.request_id = wire.request_id(),
          .error = {.code = known ? static_cast<ErrorCode>(wire.code()) : ErrorCode::kUnknown,
                    .text = printable_line(wire.text(), kMaxText),
                    .retry_after = has_retry_after ? wire.retry_after() : 0}};
}

void write(const Pong& pong, v1::ServerMessage& message) {
  v1::Pong& wire = *message.mutable_pong();
  wire.set_value(pong.value);
  wire.set_requires_token(pong.requires_token);
  wire.set_has_new_list(pong.has_new_list);
}

void write(const EstimateReply& reply, v1::ServerMessage& message) {
  v1::EstimateReply& wire = *message.mutable_estimate_reply();
  wire.set_request_id(reply.request_id);
  wire.set_triangles(reply.triangles);
  wire.set_bytes(reply.bytes);
  wire.set_error_bound_world(reply.error_bound_world);
}

EstimateReply read(const v1::EstimateReply& wire, FieldChecks& checks) {
  checks.not_negative("EstimateReply.error_bound_world", wire.error_bound_world());
  return {.request_id = wire.request_id(),
          .triangles = wire.triangles(),
          .bytes = wire.bytes(),
          .error_bound_world = wire.error_bound_world()};
}

void write(const SliceReply& reply, v1::ServerMessage& message) {
  wire::write(reply, *message.mutable_slice_reply());
}

void write(const TileScalars& scalars, v1::ServerMessage& message) {
  wire::write(scalars, *message.mutable_tile_scalars());
}

void write(const ProbeReply& reply, v1::ServerMessage& message) {
  wire::write(reply, *message.mutable_probe_reply());
}

// Checks the lengths of lists before they are read.
void check_counts(std::string_view bytes, FieldChecks& checks) {
  checks.at_most("StepBegin.tiles",
                 count_entries(bytes, {v1::ServerMessage::kStepBeginFieldNumber,
                                       v1::StepBegin::kTilesFieldNumber}),
                 kMaxTilesPerStep, "tiles");
  checks.at_most("StepBegin.request.threshold.regions",
                 count_entries(bytes, {v1::ServerMessage::kStepBeginFieldNumber,
                                       v1::StepBegin::kRequestFieldNumber,
                                       v1::IsosurfaceRequest::kThresholdFieldNumber,
                                       v1::ThresholdMap::kRegionsFieldNumber}),
                 kMaxThresholdRegions, "regions");
  checks.at_most("DatasetList.datasets",
                 count_entries(bytes, {v1::ServerMessage::kDatasetListFieldNumber,
                                       v1::DatasetList::kDatasetsFieldNumber}),
                 kMaxListedDatasets, "datasets");
  checks.at_most("ProbeReply.places",
                 count_entries(bytes, {v1::ServerMessage::kProbeReplyFieldNumber,
                                       v1::ProbeReply::kPlacesFieldNumber}),
                 kMaxProbedPlaces, "places");
}

}  // namespace

bool continues_list(const DatasetList& page, const std::vector<DatasetInfo>& earlier) {
  constexpr std::size_t kMaxDatasets = 1 << 20;
  if (page.next.empty() && earlier.empty()) return true;  // A whole list, of any order.
  if (earlier.size() + page.datasets.size() > kMaxDatasets) return false;
  const std::string* last = earlier.empty() ? nullptr : &earlier.back().name;
  for (const DatasetInfo& info : page.datasets) {
    if (last && !natural_order_less(*last, info.name)) return false;
    last = &info.name;
  }
  return page.next.empty() || (!page.datasets.empty() && page.next == *last);
}

std::string encoded_dataset(const DatasetInfo& info) {
  v1::DatasetInfo wire;
  write_dataset(info, wire);
  return wire.SerializeAsString();
}

std::string serialize(const ServerMessage& message) {
  const auto* list = std::get_if<DatasetList>(&message);
  if (list && !list->encoded.empty()) return serialize_encoded(*list);
  v1::ServerMessage bytes;
  std::visit([&bytes](const auto& alternative) { write(alternative, bytes); }, message);
  return bytes.SerializeAsString();
}

tl::expected<ServerMessage, ParseError> parse_server_message(std::string_view bytes) {
  FieldChecks checks;
  check_counts(bytes, checks);
  if (checks.first()) return refuse(checks.first()->code, checks.first()->text);
  v1::ServerMessage wire;
  if (!parse(bytes, wire)) {
    return refuse(ErrorCode::kMalformedMessage, not_a_message("ServerMessage", bytes.size()));
  }
  const auto checked = [&checks](ServerMessage message, std::uint64_t request_id) {
    return outcome(std::move(message), checks, request_id);
  };
  switch (wire.kind_case()) {
    case v1::ServerMessage::kWelcome:
      return checked(read(wire.welcome(), checks), 0);
    case v1::ServerMessage::kDatasetList:
      return checked(read(wire.dataset_list(), checks), wire.dataset_list().request_id());
    case v1::ServerMessage::kStepBegin:
      return checked(read(wire.step_begin(), checks), wire.step_begin().request_id());
    case v1::ServerMessage::kTile:
      return checked(read(*wire.mutable_tile(), checks), wire.tile().request_id());
    case v1::ServerMessage::kStepEnd:
      return checked(read(wire.step_end(), checks), wire.step_end().request_id());
    case v1::ServerMessage::kStreamEnd:
      return checked(read(wire.stream_end(), checks), wire.stream_end().request_id());
    case v1::ServerMessage::kError:
      return read(wire.error());
    case v1::ServerMessage::kPong:
      return Pong{.value = wire.pong().value(),
                  .requires_token = wire.pong().requires_token(),
                  .has_new_list = wire.pong().has_new_list()};
    case v1::ServerMessage::kEstimateReply:
      return checked(read(wire.estimate_reply(), checks), wire.estimate_reply().request_id());
    case v1::ServerMessage::kSliceReply:
      return checked(wire::read(*wire.mutable_slice_reply(), checks),
                     wire.slice_reply().request_id());
    case v1::ServerMessage::kProbeReply:
      return checked(wire::read(wire.probe_reply(), checks), wire.probe_reply().request_id());
    case v1::ServerMessage::kTileScalars:
      return checked(wire::read(*wire.mutable_tile_scalars(), checks),
                     wire.tile_scalars().request_id());
    case v1::ServerMessage::KIND_NOT_SET:
      break;
  }
  return refuse(
      ErrorCode::kMalformedMessage,
      "A ServerMessage has an unknown kind; valid kinds: welcome, dataset_list, step_begin, tile, "
      "step_end, stream_end, error, pong, estimate_reply, slice_reply, probe_reply, tile_scalars.");
}

}  // namespace multitetra

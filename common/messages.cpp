#include "common/messages.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/wire_format_lite.h>

#include "common/frame.hpp"
#include "common/utf8.hpp"
#include "multitetra/v1/conversation.pb.h"

namespace multitetra {
namespace {

// ---- limits of the wire, as documented in proto/multitetra/v1

constexpr std::size_t kMaxTilesPerStep = 262144;
constexpr std::size_t kMaxDatasets = 4096;
constexpr std::size_t kMaxHistogramBins = 65536;
constexpr std::size_t kMaxSuggestedIsovalues = 256;
constexpr std::size_t kMaxNameBytes = 255;
constexpr std::size_t kMaxTokenBytes = 4096;
constexpr std::size_t kDigestBytes = 16;
constexpr std::int32_t kMaxGridExponent = kMaxLatticeBits - kMinLatticeResolution;
constexpr std::uint64_t kMaxGridSteps = std::uint64_t{1} << kMaxGridExponent;
constexpr std::uint64_t kMaxU32 = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kMaxU64 = std::numeric_limits<std::uint64_t>::max();

// ---- enumerators: 0 is "unspecified" on the wire, our first enumerator is 1

template <typename Enum>
constexpr Enum kFirst = Enum{0};
template <>
constexpr PayloadCodec kFirst<PayloadCodec> = PayloadCodec::kDracoLattice;
template <>
constexpr StreamOutcome kFirst<StreamOutcome> = StreamOutcome::kComplete;

template <typename Wire, typename Ours>
Wire to_wire(Ours value) {
  return static_cast<Wire>(static_cast<int>(value) - static_cast<int>(kFirst<Ours>) + 1);
}

static_assert(static_cast<int>(ErrorCode::kUnavailable) == v1::ERROR_CODE_UNAVAILABLE &&
                  v1::ErrorCode_MAX == v1::ERROR_CODE_UNAVAILABLE,
              "Error codes have the same numbers in common/result.hpp and on the wire.");

// ---- strings

// Error texts may quote the world (file names, messages of libraries); the wire wants UTF-8.
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

bool is_dataset_name(std::string_view name) {
  const auto allowed = [](char c) {
    return c != '/' && c != 0x7F && (static_cast<unsigned char>(c) >= 0x20);
  };
  return !name.empty() && name.size() <= kMaxNameBytes &&
         std::all_of(name.begin(), name.end(), allowed);
}

// ---- the checks of one message

// Keeps the first thing that is wrong with a message. Values are converted all the same; nobody
// sees them when a check failed.
class FieldChecks {
 public:
  void fail(ErrorCode code, std::string text) {
    if (!first_) first_ = Error{code, std::move(text)};
  }
  void require(bool holds, std::string_view field, std::string_view rule) {
    if (!holds) fail(ErrorCode::kInvalidArgument, std::string(field) + " " + std::string(rule));
  }
  void integer(std::string_view field, std::uint64_t value, std::uint64_t low,
               std::uint64_t high = kMaxU64) {
    if (value >= low && value <= high) return;
    fail(ErrorCode::kInvalidArgument,
         std::string(field) + " is " + std::to_string(value) + "; it must be " +
             (high == kMaxU64
                  ? std::to_string(low) + " or greater."
                  : "from " + std::to_string(low) + " to " + std::to_string(high) + "."));
  }
  void finite(std::string_view field, double value) {
    require(std::isfinite(value), field, "is not a finite number; it must be one.");
  }
  void not_negative(std::string_view field, double value) {
    require(std::isfinite(value) && value >= 0, field,
            "is negative or not finite; it must be a finite number, 0 or greater.");
  }
  void exactly(std::string_view field, int size, int wanted) {
    if (size == wanted) return;
    fail(ErrorCode::kInvalidArgument, std::string(field) + " has " + std::to_string(size) +
                                          " numbers; it must have " + std::to_string(wanted) + ".");
  }
  void at_most(std::string_view field, std::size_t size, std::size_t limit, std::string_view what) {
    if (size <= limit) return;
    fail(ErrorCode::kLimitExceeded, std::string(field) + " has " + std::to_string(size) + " " +
                                        std::string(what) + "; at most " + std::to_string(limit) +
                                        " are allowed.");
  }
  // `number` as one of our enumerators up to `last`; 0 is `unspecified`, and refused when that is
  // empty.
  template <typename Ours>
  Ours enumerator(std::string_view field, int number, Ours last, std::optional<Ours> unspecified) {
    if (number == 0 && unspecified) return *unspecified;
    const int greatest = static_cast<int>(last) - static_cast<int>(kFirst<Ours>) + 1;
    if (number >= 1 && number <= greatest) {
      return static_cast<Ours>(number - 1 + static_cast<int>(kFirst<Ours>));
    }
    fail(ErrorCode::kInvalidArgument, std::string(field) + " has the number " +
                                          std::to_string(number) + "; known are 1 to " +
                                          std::to_string(greatest) + ".");
    return last;
  }

  [[nodiscard]] const std::optional<Error>& first() const { return first_; }

 private:
  std::optional<Error> first_;
};

PayloadCodec read_codec(std::string_view field, int number, FieldChecks& checks) {
  return checks.enumerator<PayloadCodec>(field, number, PayloadCodec::kDracoLattice,
                                         PayloadCodec::kDracoLattice);
}

// ---- parts that several messages share

void write(const IsosurfaceRequest& request, v1::IsosurfaceRequest& wire) {
  wire.set_isovalue(request.isovalue);
  wire.mutable_threshold()->set_everywhere(request.error);
  wire.mutable_threshold()->set_unit(to_wire<v1::LengthUnit>(request.unit));
  wire.set_measure(to_wire<v1::ErrorMeasure>(request.measure));
  wire.set_topology_rule(to_wire<v1::TopologyRule>(request.topology_rule));
  wire.set_topology_tolerance(request.topology_tolerance);
  wire.set_lattice_resolution(static_cast<std::uint32_t>(request.lattice_resolution));
}

IsosurfaceRequest read(const v1::IsosurfaceRequest& wire, FieldChecks& checks) {
  IsosurfaceRequest request;
  request.isovalue = wire.isovalue();
  if (wire.has_threshold()) request.error = wire.threshold().everywhere();
  request.unit =
      checks.enumerator<LengthUnit>("IsosurfaceRequest.threshold.unit", wire.threshold().unit(),
                                    LengthUnit::kWorld, LengthUnit::kVoxel);
  request.measure = checks.enumerator<ErrorMeasure>("IsosurfaceRequest.measure", wire.measure(),
                                                    ErrorMeasure::kPaper, ErrorMeasure::kCertified);
  request.topology_rule =
      checks.enumerator<TopologyRule>("IsosurfaceRequest.topology_rule", wire.topology_rule(),
                                      TopologyRule::kPaper, TopologyRule::kExact);
  request.topology_tolerance = wire.topology_tolerance();
  if (wire.lattice_resolution() != 0) {
    // Whatever does not fit an int is out of range anyway.
    request.lattice_resolution =
        static_cast<int>(std::min<std::uint32_t>(wire.lattice_resolution(), 1000000));
  }
  const Result<IsosurfaceRequest> valid = validated(request);
  if (!valid) checks.fail(valid.error().code, valid.error().text);
  return request;
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
  return {
      .cube = {static_cast<std::int32_t>(exponent), static_cast<std::int32_t>(wire.cube_x()),
               static_cast<std::int32_t>(wire.cube_y()), static_cast<std::int32_t>(wire.cube_z())},
      .digest = {wire.digest_high(), wire.digest_low()},
      .triangles = wire.triangles(),
      .vertices = wire.vertices(),
      .bytes = wire.bytes()};
}

void write(const DatasetInfo& info, v1::DatasetInfo& wire) {
  wire.set_name(info.name);
  for (const std::int32_t samples : info.dims) wire.add_dims(static_cast<std::uint32_t>(samples));
  wire.set_type(to_wire<v1::SampleType>(info.type));
  for (const double length : info.spacing) wire.add_spacing(length);
  for (const Vec3& column : info.index_to_world.columns) {
    for (const double number : column) wire.add_index_to_world(number);
  }
  for (const double number : info.index_to_world.translation) wire.add_index_to_world(number);
  wire.set_min(info.min);
  wire.set_max(info.max);
  wire.set_void_samples(info.void_samples);
  if (info.outside) wire.set_outside(*info.outside);
  wire.set_margin(static_cast<std::uint32_t>(info.margin));
  wire.set_grid_exponent(static_cast<std::uint32_t>(info.grid_exponent));
  wire.mutable_histogram()->set_low(info.histogram.low);
  wire.mutable_histogram()->set_high(info.histogram.high);
  wire.mutable_histogram()->mutable_counts()->Assign(info.histogram.counts.begin(),
                                                     info.histogram.counts.end());
  wire.mutable_suggested_isovalues()->Assign(info.suggested_isovalues.begin(),
                                             info.suggested_isovalues.end());
}

Histogram read(const v1::Histogram& wire, FieldChecks& checks) {
  checks.finite("DatasetInfo.histogram.low", wire.low());
  checks.finite("DatasetInfo.histogram.high", wire.high());
  checks.require(wire.low() <= wire.high(), "DatasetInfo.histogram.high",
                 "is less than its low end; it must not be.");
  checks.at_most("DatasetInfo.histogram.counts", static_cast<std::size_t>(wire.counts_size()),
                 kMaxHistogramBins, "bins");
  return {.low = wire.low(),
          .high = wire.high(),
          .counts = {wire.counts().begin(), wire.counts().end()}};
}

// The samples' places: dims, spacing, affine, margin, grid.
void read_places(const v1::DatasetInfo& wire, DatasetInfo& info, FieldChecks& checks) {
  checks.exactly("DatasetInfo.dims", wire.dims_size(), 3);
  checks.exactly("DatasetInfo.spacing", wire.spacing_size(), 3);
  checks.exactly("DatasetInfo.index_to_world", wire.index_to_world_size(), 12);
  checks.integer("DatasetInfo.margin", wire.margin(), 0, kMaxGridSteps / 2);
  checks.integer("DatasetInfo.grid_exponent", wire.grid_exponent(), 1, kMaxGridExponent);
  if (checks.first()) return;
  std::uint64_t samples = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    checks.integer("DatasetInfo.dims", wire.dims(axis), 1, kMaxGridSteps + 1);
    info.dims[at] = static_cast<std::int32_t>(wire.dims(axis));
    samples *= wire.dims(axis);
    checks.require(std::isfinite(wire.spacing(axis)) && wire.spacing(axis) > 0,
                   "DatasetInfo.spacing", "must be finite and greater than 0 on every axis.");
    info.spacing[at] = wire.spacing(axis);
    for (int row = 0; row < 3; ++row) {
      info.index_to_world.columns[at][static_cast<std::size_t>(row)] =
          wire.index_to_world(3 * axis + row);
    }
    info.index_to_world.translation[at] = wire.index_to_world(9 + axis);
  }
  for (const double number : wire.index_to_world()) {
    checks.finite("DatasetInfo.index_to_world", number);
  }
  if (checks.first()) return;
  checks.integer("DatasetInfo.void_samples", wire.void_samples(), 0, samples);
  info.margin = static_cast<std::int32_t>(wire.margin());
  info.grid_exponent = static_cast<std::int32_t>(wire.grid_exponent());
  checks.require(info.grid_exponent >= grid_exponent_for(info.dims, info.margin),
                 "DatasetInfo.grid_exponent", "is too small for the samples and the margin.");
}

DatasetInfo read(const v1::DatasetInfo& wire, FieldChecks& checks) {
  DatasetInfo info;
  checks.require(is_dataset_name(wire.name()), "DatasetInfo.name",
                 "must have 1 to 255 bytes, no '/' and no control characters.");
  info.name = wire.name();
  info.type = checks.enumerator<SampleType>("DatasetInfo.type", wire.type(), SampleType::kF32, {});
  read_places(wire, info, checks);
  checks.finite("DatasetInfo.min", wire.min());
  checks.finite("DatasetInfo.max", wire.max());
  checks.require(wire.min() <= wire.max(), "DatasetInfo.max", "is less than min; it must not be.");
  info.min = wire.min();
  info.max = wire.max();
  info.void_samples = wire.void_samples();
  if (wire.has_outside()) {
    checks.finite("DatasetInfo.outside", wire.outside());
    info.outside = wire.outside();
  }
  info.histogram = read(wire.histogram(), checks);
  checks.at_most("DatasetInfo.suggested_isovalues",
                 static_cast<std::size_t>(wire.suggested_isovalues_size()), kMaxSuggestedIsovalues,
                 "values");
  for (const double value : wire.suggested_isovalues()) {
    checks.finite("DatasetInfo.suggested_isovalues", value);
    info.suggested_isovalues.push_back(value);
  }
  return info;
}

// Digests, 16 bytes each: high then low, little-endian.
void append_u64(std::uint64_t value, std::string& bytes) {
  for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
}

std::uint64_t u64_at(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 8; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::vector<ContentDigest> read_held(std::string_view bytes, FieldChecks& checks) {
  checks.require(bytes.size() % kDigestBytes == 0, "OpenStream.held",
                 "must have 16 bytes for each digest.");
  checks.at_most("OpenStream.held", bytes.size() / kDigestBytes, kMaxHeldDigests, "digests");
  std::vector<ContentDigest> held;
  if (checks.first()) return held;
  held.reserve(bytes.size() / kDigestBytes);
  for (; !bytes.empty(); bytes.remove_prefix(kDigestBytes)) {
    held.push_back({u64_at(bytes), u64_at(bytes.substr(8))});
  }
  return held;
}

// ---- client to server

void write(const Hello& hello, v1::ClientMessage& message) {
  v1::Hello& wire = *message.mutable_hello();
  wire.set_min_version(hello.min_version);
  wire.set_max_version(hello.max_version);
  for (const PayloadCodec codec : hello.codecs) wire.add_codecs(to_wire<v1::PayloadCodec>(codec));
  wire.set_token(hello.token);
  wire.set_agent(hello.agent);
}

Hello read(const v1::Hello& wire, FieldChecks& checks) {
  Hello hello;
  hello.min_version = wire.min_version() == 0 ? kProtocolVersion : wire.min_version();
  hello.max_version = wire.max_version() == 0 ? hello.min_version : wire.max_version();
  checks.integer("Hello.max_version", hello.max_version, hello.min_version, kMaxU32);
  if (!wire.codecs().empty()) {
    const auto known = static_cast<int>(v1::PAYLOAD_CODEC_DRACO_LATTICE);
    hello.codecs.clear();
    if (std::find(wire.codecs().begin(), wire.codecs().end(), known) != wire.codecs().end()) {
      hello.codecs.push_back(PayloadCodec::kDracoLattice);
    }
    checks.require(!hello.codecs.empty(), "Hello.codecs",
                   "names no payload codec known here; known is 1 (Draco lattice).");
  }
  checks.at_most("Hello.token", wire.token().size(), kMaxTokenBytes, "bytes");
  checks.at_most("Hello.agent", wire.agent().size(), kMaxNameBytes, "bytes");
  hello.token = wire.token();
  hello.agent = wire.agent();
  return hello;
}

void write(const ListDatasets& list, v1::ClientMessage& message) {
  message.mutable_list_datasets()->set_request_id(list.request_id);
}

void write(const OpenStream& open, v1::ClientMessage& message) {
  v1::OpenStream& wire = *message.mutable_open_stream();
  wire.set_request_id(open.request_id);
  wire.set_dataset(open.dataset);
  write(open.request, *wire.mutable_request());
  wire.set_steps(to_wire<v1::StepPolicy>(open.steps));
  wire.mutable_held()->reserve(open.held.size() * kDigestBytes);
  for (const ContentDigest& digest : open.held) {
    append_u64(digest.high, *wire.mutable_held());
    append_u64(digest.low, *wire.mutable_held());
  }
}

OpenStream read(const v1::OpenStream& wire, FieldChecks& checks) {
  OpenStream open;
  checks.integer("OpenStream.request_id", wire.request_id(), 1);
  checks.require(is_dataset_name(wire.dataset()), "OpenStream.dataset",
                 "must have 1 to 255 bytes, no '/' and no control characters.");
  open.request_id = wire.request_id();
  open.dataset = wire.dataset();
  open.request = read(wire.request(), checks);
  open.steps = checks.enumerator<StepPolicy>("OpenStream.steps", wire.steps(),
                                             StepPolicy::kFinalOnly, StepPolicy::kProgressive);
  open.held = read_held(wire.held(), checks);
  return open;
}

void write(const Cancel& cancel, v1::ClientMessage& message) {
  message.mutable_cancel()->set_request_id(cancel.request_id);
}

void write(const Ping& ping, v1::ClientMessage& message) {
  message.mutable_ping()->set_value(ping.value);
}

// ---- server to client

void write(const Welcome& welcome, v1::ServerMessage& message) {
  v1::Welcome& wire = *message.mutable_welcome();
  wire.set_version(welcome.version);
  wire.set_codec(to_wire<v1::PayloadCodec>(welcome.codec));
  wire.set_agent(welcome.agent);
  wire.set_max_message_bytes(welcome.max_message_bytes);
}

Welcome read(const v1::Welcome& wire, FieldChecks& checks) {
  checks.integer("Welcome.version", wire.version(), 1, kMaxU32);
  checks.at_most("Welcome.agent", wire.agent().size(), kMaxNameBytes, "bytes");
  return {.version = wire.version(),
          .codec = read_codec("Welcome.codec", wire.codec(), checks),
          .agent = wire.agent(),
          .max_message_bytes = wire.max_message_bytes()};
}

void write(const DatasetList& list, v1::ServerMessage& message) {
  v1::DatasetList& wire = *message.mutable_dataset_list();
  wire.set_request_id(list.request_id);
  for (const DatasetInfo& info : list.datasets) write(info, *wire.add_datasets());
}

DatasetList read(const v1::DatasetList& wire, FieldChecks& checks) {
  DatasetList list{.request_id = wire.request_id(), .datasets = {}};
  for (const v1::DatasetInfo& info : wire.datasets()) {
    list.datasets.push_back(read(info, checks));
    if (checks.first()) break;
  }
  return list;
}

void write(const StepBegin& begin, v1::ServerMessage& message) {
  v1::StepBegin& wire = *message.mutable_step_begin();
  wire.set_request_id(begin.request_id);
  wire.set_step(begin.step);
  wire.set_is_final(begin.is_final);
  write(begin.request, *wire.mutable_request());
  wire.set_error_bound_world(begin.error_bound_world);
  wire.set_finest_spacing(static_cast<std::uint32_t>(begin.finest_spacing));
  wire.set_codec(to_wire<v1::PayloadCodec>(begin.codec));
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
  begin.request = read(wire.request(), checks);
  checks.not_negative("StepBegin.error_bound_world", wire.error_bound_world());
  begin.error_bound_world = wire.error_bound_world();
  const std::uint32_t spacing = std::max<std::uint32_t>(wire.finest_spacing(), 1);
  checks.require(std::has_single_bit(spacing) && spacing <= kMaxGridSteps,
                 "StepBegin.finest_spacing", "must be a power of two from 1 to 2^19.");
  begin.finest_spacing = static_cast<std::int32_t>(spacing);
  begin.codec = read_codec("StepBegin.codec", wire.codec(), checks);
  checks.integer("StepBegin.active_tetrahedra", wire.active_tetrahedra(), 0, wire.tetrahedra());
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
  checks.require(!wire.payload().empty(), "Tile.payload", "is empty; it must have a byte or more.");
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
}

ErrorReply read(const v1::ErrorReply& wire) {
  const bool known = v1::ErrorCode_IsValid(wire.code());
  return {
      .request_id = wire.request_id(),
      .error = {known ? static_cast<ErrorCode>(wire.code()) : ErrorCode::kUnknown, wire.text()}};
}

void write(const Pong& pong, v1::ServerMessage& message) {
  message.mutable_pong()->set_value(pong.value);
}

// ---- the doors

template <typename Wire, typename Message>
std::string serialized(const Message& message) {
  Wire wire;
  std::visit([&wire](const auto& alternative) { write(alternative, wire); }, message);
  return wire.SerializeAsString();
}

// How many entries of the repeated message `inner` the fields `outer` hold together, also where the
// message names `outer` several times. An entry costs the parser about 100 times its two bytes, so
// they are counted before it runs.
std::size_t count_entries(std::string_view bytes, int outer, int inner) {
  using google::protobuf::internal::WireFormatLite;
  constexpr auto kDelimited = WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
  google::protobuf::io::CodedInputStream input(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                               static_cast<int>(bytes.size()));
  std::size_t entries = 0;
  while (const std::uint32_t tag = input.ReadTag()) {
    std::uint32_t length = 0;
    if (tag == WireFormatLite::MakeTag(outer, kDelimited) && input.ReadVarint32(&length)) {
      const auto limit = input.PushLimit(static_cast<int>(std::min<std::uint64_t>(
          length, static_cast<std::uint64_t>(std::numeric_limits<int>::max()))));
      while (const std::uint32_t inner_tag = input.ReadTag()) {
        entries += inner_tag == WireFormatLite::MakeTag(inner, kDelimited);
        if (!WireFormatLite::SkipField(&input, inner_tag)) return entries;
      }
      input.PopLimit(limit);
    } else if (!WireFormatLite::SkipField(&input, tag)) {
      return entries;
    }
  }
  return entries;
}

tl::unexpected<ParseError> refuse(ErrorCode code, std::string text, std::uint64_t request_id = 0) {
  return tl::unexpected<ParseError>(ParseError{{code, std::move(text)}, request_id});
}

// Protobuf would write a line on stderr for every string that is not UTF-8: a way for strangers to
// fill our log.
void silence_protobuf_log() {
  [[maybe_unused]] static const auto silenced = google::protobuf::SetLogHandler(nullptr);
}

template <typename Wire>
bool parse(std::string_view bytes, Wire& wire) {
  silence_protobuf_log();
  return bytes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
         wire.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

template <typename Message>
tl::expected<Message, ParseError> outcome(Message message, const FieldChecks& checks,
                                          std::uint64_t request_id) {
  if (checks.first()) return refuse(checks.first()->code, checks.first()->text, request_id);
  return message;
}

std::string not_a_message(std::string_view whose, std::size_t bytes) {
  return std::to_string(bytes) + " bytes are no message of multitetra.v1; a " + std::string(whose) +
         " was expected.";
}

}  // namespace

std::string serialize(const ClientMessage& message) {
  return serialized<v1::ClientMessage>(message);
}

std::string serialize(const ServerMessage& message) {
  return serialized<v1::ServerMessage>(message);
}

tl::expected<ClientMessage, ParseError> parse_client_message(std::string_view bytes) {
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
      return ListDatasets{wire.list_datasets().request_id()};
    case v1::ClientMessage::kOpenStream:
      return checked(read(wire.open_stream(), checks), wire.open_stream().request_id());
    case v1::ClientMessage::kCancel:
      return Cancel{wire.cancel().request_id()};
    case v1::ClientMessage::kPing:
      return Ping{wire.ping().value()};
    case v1::ClientMessage::KIND_NOT_SET:
      break;
  }
  return refuse(ErrorCode::kMalformedMessage,
                "A ClientMessage has none of the kinds known here: hello, list_datasets, "
                "open_stream, cancel, ping.");
}

tl::expected<ServerMessage, ParseError> parse_server_message(std::string_view bytes) {
  FieldChecks checks;
  checks.at_most("StepBegin.tiles",
                 count_entries(bytes, v1::ServerMessage::kStepBeginFieldNumber,
                               v1::StepBegin::kTilesFieldNumber),
                 kMaxTilesPerStep, "tiles");
  checks.at_most("DatasetList.datasets",
                 count_entries(bytes, v1::ServerMessage::kDatasetListFieldNumber,
                               v1::DatasetList::kDatasetsFieldNumber),
                 kMaxDatasets, "datasets");
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
      return Pong{wire.pong().value()};
    case v1::ServerMessage::KIND_NOT_SET:
      break;
  }
  return refuse(ErrorCode::kMalformedMessage,
                "A ServerMessage has none of the kinds known here: welcome, dataset_list, "
                "step_begin, tile, step_end, stream_end, error, pong.");
}

}  // namespace multitetra

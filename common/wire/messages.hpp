// The messages of the protocol as plain structs, and their bytes. Only client_messages.cpp,
// server_messages.cpp and their wire_* helpers use the generated protobuf code.
//
//   client                               server
//   Hello                       ->
//                               <-       Welcome (or Error, then the connection ends)
//   ListDatasets                ->
//                               <-       DatasetList
//   OpenStream                  ->
//                               <-       StepBegin, Tile..., StepEnd      once for each step
//                               <-       StreamEnd (or Error with the request's id)
//   Cancel, Ping                ->
//                               <-       StreamEnd(cancelled), Pong
//   Estimate, Slice, Probe      ->
//                               <-       EstimateReply, SliceReply, ProbeReply
//
// The parse_*() functions are the entry points for untrusted bytes: they check the documented range
// of every field, so their results are safe to use. They ignore unknown fields, for compatibility.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/result.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/preview.hpp"
#include "common/request/probe_request.hpp"
#include "common/request/scalar_request.hpp"
#include "common/request/slice_request.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {

inline constexpr std::uint32_t kProtocolVersion = 1;

// The encoding of a tile's payload; negotiated in Hello and Welcome. Draco is always supported.
enum class PayloadCodec { kDracoLattice = 1, kSampleShell = 2 };

// ---- client to server

struct Hello {
  // The range of protocol versions the client speaks, inclusive.
  std::uint32_t min_version = kProtocolVersion;
  std::uint32_t max_version = kProtocolVersion;
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice};
  std::string token = {};  // Bearer token, or empty; at most 4096 bytes.
  std::string agent = {};  // Program and version, for logs; at most 255 bytes.
  // Set by gateways: identifies the gateway's client to servers that trust it; at most 512 bytes.
  std::string on_behalf_of = {};
  // Set by gateways: the address of the gateway's client, for the log; at most 255 bytes.
  std::string client_address = {};
};

struct ListDatasets {
  std::uint64_t request_id = 0;
  bool in_pages = false;   // One page; else up to kMaxListedDatasets.
  std::string after = {};  // The name that the page follows; empty: the first page.
};
inline constexpr std::size_t kMaxListedDatasets = 4096;

// The steps of a stream.
enum class StepPolicy {
  kProgressive,  // Previews chosen by the server, then the final step.
  kFinalOnly,
  kPreviewsOnly,  // The final step only if it is available as soon as a preview.
};

// The client's use of the meshes of a stream.
enum class MeshUse {
  kKeep,     // The final step meets the request exactly.
  kDisplay,  // The final step may be a full-resolution shell within all thresholds.
};

enum class Priority {
  kNormal,      // A client waits for the reply.
  kBackground,  // Served after all normal requests.
};

struct OpenStream {
  // Chosen by the client; > 0, and greater than all earlier ones of this connection.
  std::uint64_t request_id = 0;
  std::string dataset = {};
  IsosurfaceRequest request = {};
  StepPolicy steps = StepPolicy::kProgressive;
  // Tiles the client already has, at most kMaxHeldDigests.
  std::vector<ContentDigest> cached_tile_digests = {};
  // The previews received before the stream was interrupted, at most kMaxPreviews, each finer than
  // the one before. Exactly these are sent again, followed by the steps of `steps`.
  std::vector<Preview> resumed_previews = {};
  Priority priority = Priority::kNormal;
  std::optional<ScalarRequest> scalars = {};
  // The client's speed of decoding, checking and displaying; finite, >= 0. 0: unknown.
  double triangles_per_second = 0;
  MeshUse use = MeshUse::kKeep;
  // With kDisplay: the maximum triangles of a full-resolution step of sample shells. 0: 12 million.
  std::uint64_t drawable_triangles = 0;
  // Step i is the one preview of the i-th dataset, `dataset` being the first; at most
  // kMaxFurtherDatasets. Requires kPreviewsOnly and exactly one of resumed_previews, without
  // digests, scalars and cell.
  std::vector<std::string> further_datasets = {};
  // DatasetInfo::content_id of the dataset that is meant; a server that has another one refuses. 0:
  // any.
  std::uint64_t content_id = 0;
};
inline constexpr std::size_t kMaxHeldDigests = 8192;
inline constexpr std::size_t kMaxFurtherDatasets = 1023;

struct Cancel {
  std::uint64_t request_id = 0;
};

struct Ping {
  std::uint64_t value = 0;
};

// Requests the expected size of a surface.
struct Estimate {
  std::uint64_t request_id = 0;
  std::string dataset = {};
  IsosurfaceRequest request = {};
  Priority priority = Priority::kNormal;
  std::uint64_t content_id = 0;  // As in OpenStream.
};

// Requests the field on a plane.
struct Slice {
  std::uint64_t request_id = 0;
  std::string dataset = {};
  SliceRequest slice = {};
  Priority priority = Priority::kNormal;
  std::uint64_t content_id = 0;  // As in OpenStream.
};

// Requests the field at the given places.
struct Probe {
  std::uint64_t request_id = 0;
  std::string dataset = {};
  ProbeRequest probe = {};
  std::uint64_t content_id = 0;  // As in OpenStream.
};

using ClientMessage =
    std::variant<Hello, ListDatasets, OpenStream, Cancel, Ping, Estimate, Slice, Probe>;

// ---- server to client

struct Welcome {
  std::uint32_t version = kProtocolVersion;  // The version both sides use.
  // The codecs of payloads on this connection.
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice};
  std::string agent = {};
  std::uint32_t max_message_bytes = 0;  // The longest client message the server accepts.
};

struct DatasetList {
  std::uint64_t request_id = 0;
  std::vector<DatasetInfo> datasets = {};  // In natural order of names.
  std::string next = {};                   // The next page's ListDatasets::after; empty: none.
  // Further datasets, each from encoded_dataset(). Only servers use this; received lists have none.
  std::vector<std::shared_ptr<const std::string>> encoded = {};
};

// Returns whether a page may follow the datasets of earlier pages: its names go on in order and
// `next` is its last one, so a list of pages ends.
[[nodiscard]] bool continues_list(const DatasetList& page, const std::vector<DatasetInfo>& earlier);

// Returns a dataset as it stands in a serialized DatasetList.
[[nodiscard]] std::string encoded_dataset(const DatasetInfo& info);

// A step is a complete conforming model. It replaces the previous step as a whole once its StepEnd
// has arrived.
struct StepBegin {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;  // 0, 1, ... within the stream.
  // The step meets the request, or suffices for MeshUse::kDisplay.
  bool is_final = false;
  IsosurfaceRequest request = {};  // The parameters of this step; `error` in the request's unit.
  // The largest threshold anywhere, in world units. Bounds the distance to the full-resolution
  // surface (excluding lattice snapping) if the measure is certified, topology_tolerance is 0 and
  // finest_spacing is 1. With shells: the largest displacement of a vertex by quantized values, 0
  // with other values.
  double error_bound_world = 0;
  std::int32_t finest_spacing = 1;      // In grid steps: the model has no finer dividing points.
  std::optional<ShellStep> shell = {};  // Set for sample shells; absent: Draco.
  // Tetrahedra of the model; 0 with shells.
  std::uint64_t tetrahedra = 0;
  // Tetrahedra the surface crosses; 0 with shells.
  std::uint64_t active_tetrahedra = 0;
  // All tiles of the step, including those the client has.
  std::vector<TileSummary> tiles = {};
  bool is_unsimplified = false;  // Although the request allows simplification.
  // For a request with a cell: bit i is set if OctreeCube::child(i) of its cube may contain a
  // surface at some error.
  std::uint32_t crossed_octants = 0;
  // The range of the vertices' scalars; absent: no scalars.
  std::optional<ScalarRange> scalars = {};
};

// Updates the request so that it resumes the stream, on any server, after `step` was received.
// Returns false for a step that no request can name, as it is not finer than the one before.
[[nodiscard]] bool record_started_step(const StepBegin& step, OpenStream& open);

struct Tile {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;
  std::uint32_t index = 0;  // Index into StepBegin::tiles.
  std::shared_ptr<const std::string> payload = {};
};

// The values of a field at the vertices of a tile, see scalar_codes.hpp.
struct TileScalars {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;
  std::uint32_t index = 0;  // Index into StepBegin::tiles.
  std::shared_ptr<const std::string> codes = {};
  // The largest difference found between the field and its linear interpolation over the triangles,
  // in sample values, excluding rounding to codes.
  double largest_deviation = 0;
};

struct StepEnd {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;
  // Excludes tiles the client has.
  std::uint32_t tiles_sent = 0;
  // The total size of the tiles sent.
  std::uint64_t payload_bytes = 0;
  // The sum of the digests of all tiles.
  ContentDigest digest = {};
  double seconds = 0;  // The time the server took for this step.
};

enum class StreamOutcome { kComplete = 1, kCancelled = 2, kSuperseded = 3 };

struct StreamEnd {
  std::uint64_t request_id = 0;
  StreamOutcome outcome = StreamOutcome::kComplete;
  std::uint32_t steps = 0;  // The number of steps whose StepEnd was sent.
};

struct ErrorReply {
  std::uint64_t request_id = 0;  // 0 if the error concerns the connection.
  Error error = {};
};

struct Pong {
  std::uint64_t value = 0;
  bool requires_token = false;  // Before Welcome: a Hello without a token is refused.
  bool has_new_list = false;    // The datasets have changed since the connection's last list.
};

struct EstimateReply {
  std::uint64_t request_id = 0;
  std::uint64_t triangles = 0;   // The estimated number of triangles of the final step.
  std::uint64_t bytes = 0;       // The estimated number of payload bytes.
  double error_bound_world = 0;  // The largest threshold anywhere, in world units.
};

struct SliceReply {
  std::uint64_t request_id = 0;
  // The requested size.
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t layers = 1;
  std::uint32_t sample_spacing = 1;  // 1, or 8 if every eighth sample was used.
  // A little-endian float per pixel, layer by layer and row by row; NaN where there is no field.
  std::shared_ptr<const std::string> values = {};
  // Set if the values are packed as numbers of this type (packed_values.hpp).
  std::optional<SampleType> packed_type = {};
};

struct ProbeReply {
  std::uint64_t request_id = 0;
  // The places, in the order of the request.
  std::vector<ProbedPlace> places = {};
};

using ServerMessage =
    std::variant<Welcome, DatasetList, StepBegin, Tile, StepEnd, StreamEnd, ErrorReply, Pong,
                 EstimateReply, SliceReply, ProbeReply, TileScalars>;

// Returns the content of one frame or WebSocket message.
[[nodiscard]] std::string serialize(const ClientMessage& message);
[[nodiscard]] std::string serialize(const ServerMessage& message);

// kMalformedMessage if the bytes are no message; kInvalidArgument or kLimitExceeded if a field is
// out of range, with the request's id if known: then the connection can stay open.
struct ParseError {
  Error error;
  std::uint64_t request_id = 0;
};
[[nodiscard]] tl::expected<ClientMessage, ParseError> parse_client_message(std::string_view bytes);
[[nodiscard]] tl::expected<ServerMessage, ParseError> parse_server_message(std::string_view bytes);

}  // namespace multitetra

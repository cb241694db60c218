// The conversation as plain structs, and their bytes. No generated protobuf code is seen from here:
// client_messages.cpp, server_messages.cpp and their wire_* helpers keep it to themselves.
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
// parse_* are the entry point for untrusted bytes: every field is checked for its documented range,
// and what they return is safe to use. Unknown fields are ignored, so that old peers keep working.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/result.hpp"
#include "common/request/dataset_info.hpp"
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
  std::uint32_t min_version =
      kProtocolVersion;  // Inclusive range of protocol versions the client speaks.
  std::uint32_t max_version = kProtocolVersion;
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice};
  std::string token = {};  // Bearer token, empty without; at most 4096 bytes.
  std::string agent = {};  // Program and version, for logs; at most 255 bytes.
  // From a gateway: the identity of its client, for servers that trust it; at most 512 bytes.
  std::string on_behalf_of = {};
  // Likewise: the address of its client, for the log; at most 255 bytes.
  std::string client_address = {};
};

struct ListDatasets {
  std::uint64_t request_id = 0;
};

// The steps of a stream.
enum class StepPolicy {
  kProgressive,  // Previews chosen by the server, then the request itself.
  kFinalOnly,
  kPreviewsOnly,  // The request itself only where it is there as soon as a preview.
};

// The client's use of the meshes of a stream.
enum class MeshUse {
  kKeep,     // The final step is the request itself.
  kDisplay,  // The final step may be a full-resolution shell that is within all thresholds.
};

enum class Priority {
  kNormal,      // A client waits for it.
  kBackground,  // It comes after all that is normal.
};

struct OpenStream {
  std::uint64_t request_id =
      0;  // Chosen by the client, > 0, greater than those before on this connection.
  std::string dataset = {};
  IsosurfaceRequest request = {};
  StepPolicy steps = StepPolicy::kProgressive;
  // Tiles that the client has already, at most kMaxHeldDigests.
  std::vector<ContentDigest> cached_tile_digests = {};
  // The previews that the stream began with elsewhere, at most kMaxPreviews, each finer than the
  // one before: exactly these previews come again, and then those of `steps`.
  std::vector<Preview> resumed_previews = {};
  Priority priority = Priority::kNormal;
  std::optional<ScalarRequest> scalars = {};
  // The client's speed of decoding, checking and showing; finite, >= 0. 0: unknown.
  double triangles_per_second = 0;
  MeshUse use = MeshUse::kKeep;
};
inline constexpr std::size_t kMaxHeldDigests = 8192;

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
};

// Requests the field on a plane.
struct Slice {
  std::uint64_t request_id = 0;
  std::string dataset = {};
  SliceRequest slice = {};
  Priority priority = Priority::kNormal;
};

// Requests the field at some places.
struct Probe {
  std::uint64_t request_id = 0;
  std::string dataset = {};
  ProbeRequest probe = {};
};

using ClientMessage =
    std::variant<Hello, ListDatasets, OpenStream, Cancel, Ping, Estimate, Slice, Probe>;

// ---- server to client

struct Welcome {
  std::uint32_t version = kProtocolVersion;  // The version both speak from now on.
  // The codecs of payloads on this connection.
  std::vector<PayloadCodec> codecs = {PayloadCodec::kDracoLattice};
  std::string agent = {};
  std::uint32_t max_message_bytes = 0;  // The longest client message that the server accepts.
};

struct DatasetList {
  std::uint64_t request_id = 0;
  std::vector<DatasetInfo> datasets = {};  // By name.
};

// A step is a complete conforming model. It replaces the one before as a whole, when its StepEnd
// has come.
struct StepBegin {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;  // 0, 1, ... within the stream.
  bool is_final = false;   // This step is the request itself, or all that MeshUse::kDisplay needs.
  IsosurfaceRequest request = {};  // This step's own parameters; `error` in the request's unit.
  // The largest threshold anywhere, world units. It bounds the distance to the full surface
  // (lattice snapping excluded) when the measure is certified, topology_tolerance is 0 and
  // finest_spacing is 1. Of shells: what quantized values move a vertex by at most, 0 with others.
  double error_bound_world = 0;
  std::int32_t finest_spacing = 1;      // Grid steps; no finer dividing point takes part.
  std::optional<ShellStep> shell = {};  // For sample shells; none: Draco.
  // Tetrahedra of the model; 0 with shells.
  std::uint64_t tetrahedra = 0;
  // Those that the surface crosses; 0 with shells.
  std::uint64_t active_tetrahedra = 0;
  // All tiles of the step, those that the client holds included.
  std::vector<TileSummary> tiles = {};
  bool is_unsimplified = false;  // No tile is simplified, though the request allows it.
  // For a request with a cell: bit i is set where OctreeCube::child(i) of its cube may have a
  // surface at any error.
  std::uint32_t crossed_octants = 0;
  // For the tiles' vertices; none: no scalars.
  std::optional<ScalarRange> scalars = {};
};

// The request that resumes a stream of which that much was received, on any server.
void record_started_step(const StepBegin& step, OpenStream& open);

struct Tile {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;
  std::uint32_t index = 0;  // Into StepBegin::tiles.
  std::shared_ptr<const std::string> payload = {};
};

// The values of a field at the vertices of a tile, see scalar_codes.hpp.
struct TileScalars {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;
  std::uint32_t index = 0;  // Into StepBegin::tiles.
  std::shared_ptr<const std::string> codes = {};
  // The largest difference that was found between the field and what is interpolated between the
  // corners of a triangle, without rounding to codes. In sample values.
  double largest_deviation = 0;
};

struct StepEnd {
  std::uint64_t request_id = 0;
  std::uint32_t step = 0;
  std::uint32_t tiles_sent = 0;  // Without those that the client held.
  // The payloads of the tiles sent.
  std::uint64_t payload_bytes = 0;
  // The digest of the whole step.
  ContentDigest digest = {};
  double seconds = 0;  // The server's time for this step.
};

enum class StreamOutcome { kComplete = 1, kCancelled = 2, kSuperseded = 3 };

struct StreamEnd {
  std::uint64_t request_id = 0;
  StreamOutcome outcome = StreamOutcome::kComplete;
  std::uint32_t steps = 0;  // Steps that were ended.
};

struct ErrorReply {
  std::uint64_t request_id = 0;  // 0 when it concerns the connection.
  Error error = {};
};

struct Pong {
  std::uint64_t value = 0;
};

struct EstimateReply {
  std::uint64_t request_id = 0;
  std::uint64_t triangles = 0;  // About as many as the final step would have,
  std::uint64_t bytes = 0;      // and payload bytes.
  double threshold_world = 0;   // The largest threshold anywhere, world units.
};

struct SliceReply {
  std::uint64_t request_id = 0;
  // As requested.
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t sample_spacing = 1;  // 1, or 8 where every eighth sample was used.
  // A float for each pixel, row by row, NaN where there is no field: 4 bytes each, little-endian.
  std::shared_ptr<const std::string> values = {};
};

struct ProbeReply {
  std::uint64_t request_id = 0;
  // In the order of the request.
  std::vector<ProbedPlace> places = {};
};

using ServerMessage =
    std::variant<Welcome, DatasetList, StepBegin, Tile, StepEnd, StreamEnd, ErrorReply, Pong,
                 EstimateReply, SliceReply, ProbeReply, TileScalars>;

// The content of one frame or one WebSocket message.
[[nodiscard]] std::string serialize(const ClientMessage& message);
[[nodiscard]] std::string serialize(const ServerMessage& message);

// kMalformedMessage when the bytes are no message; kInvalidArgument or kLimitExceeded, with the
// request id where one could be read, when a field is outside its range: the connection can remain
// open after those.
struct ParseError {
  Error error;
  std::uint64_t request_id = 0;
};
[[nodiscard]] tl::expected<ClientMessage, ParseError> parse_client_message(std::string_view bytes);
[[nodiscard]] tl::expected<ServerMessage, ParseError> parse_server_message(std::string_view bytes);

}  // namespace multitetra

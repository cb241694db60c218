#include "common/wire/shell_tile.hpp"

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "common/codec/shell_decoder.hpp"

namespace multitetra {
namespace {

using shell::ShellHeader;
using shell::ShellStatus;

tl::unexpected<Error> bad_shell(const TileSummary& tile, const std::string& what) {
  return fail(ErrorCode::kDamagedData, "Tile at " + to_string(tile.cube) + ": " + what);
}

Result<ShellHeader> header_of(std::string_view payload, const TileSummary& promised) {
  ShellHeader header;
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(payload.data());
  switch (read_shell_header(bytes, payload.size(), header)) {
    case ShellStatus::kOk:
      return header;
    case ShellStatus::kUnknownVersion:
      return bad_shell(promised, "the payload is not a sample shell of version 1.");
    case ShellStatus::kBadHeader:
    case ShellStatus::kBadContents:
      break;
  }
  return bad_shell(promised, "the payload has no valid sample shell header.");
}

bool lies_in(const ShellHeader& header, const OctreeCube& cube) {
  const std::array<std::int32_t, 3> position = {cube.x, cube.y, cube.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t low = std::int64_t{header.origin[axis]} << header.spacing_exponent;
    const std::int64_t high =
        low + (std::int64_t{header.samples[axis] - 1} << header.spacing_exponent);
    const std::int64_t first = std::int64_t{position[axis]} << cube.exponent;
    if (low < first || high > first + cube.side()) return false;
  }
  return true;
}

bool has_form(const ShellHeader& header, const ShellTileForm& form) {
  return header.lattice_resolution == form.lattice_resolution &&
         std::int32_t{1} << header.spacing_exponent == form.finest_spacing &&
         header.values == form.shell.values &&
         (header.values != shell::ShellValues::kQuantized ||
          header.levels_per_octave == form.shell.levels_per_octave);
}

// Buffers that are reused by all decoding calls of a thread.
struct ShellMemory {
  shell::ShellDecoder decoder;
  std::vector<shell::ShellVertex> vertices;
  std::vector<shell::ShellTriangle> triangles;
};

}  // namespace

Result<void> check_shell_tile(std::string_view payload, const TileSummary& promised,
                              const ShellTileForm& form) {
  if (const ContentDigest found = digest_of_bytes(payload); found != promised.digest) {
    return bad_shell(promised, "the payload has the digest " + found.hex() +
                                   "; the manifest lists " + promised.digest.hex() + ".");
  }
  const Result<ShellHeader> header = header_of(payload, promised);
  if (!header) return tl::unexpected(header.error());
  if (header->triangles != promised.triangles || header->vertices != promised.vertices) {
    return bad_shell(promised, "the payload has " + std::to_string(header->triangles) +
                                   " triangles and " + std::to_string(header->vertices) +
                                   " vertices; the manifest lists " +
                                   std::to_string(promised.triangles) + " and " +
                                   std::to_string(promised.vertices) + ".");
  }
  if (!has_form(*header, form)) {
    return bad_shell(
        promised, "the values, spacing or lattice of the payload differ from those of its step.");
  }
  if (!lies_in(*header, promised.cube)) {
    return bad_shell(promised, "the payload's box extends beyond the tile's cube.");
  }
  return {};
}

std::optional<MarchedBox> marched_box(std::string_view payload) {
  ShellHeader header;
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(payload.data());
  const ShellStatus status = read_shell_header(bytes, payload.size(), header);
  if (status != ShellStatus::kOk || header.has_void) return std::nullopt;
  const auto corner = [&header](std::int32_t x, std::int32_t y, std::int32_t z) {
    const std::int32_t steps = header.steps();
    return LatticePoint{(header.origin[0] + x) * steps, (header.origin[1] + y) * steps,
                        (header.origin[2] + z) * steps};
  };
  return MarchedBox{
      .low = corner(0, 0, 0),
      .high = corner(header.samples[0] - 1, header.samples[1] - 1, header.samples[2] - 1)};
}

Result<LatticeMesh> decode_shell_tile(std::string_view payload, const TileSummary& promised,
                                      const ShellTileForm& form) {
  if (const auto checked = check_shell_tile(payload, promised, form); !checked) {
    return tl::unexpected(checked.error());
  }
  thread_local const auto memory = std::make_unique<ShellMemory>();
  memory->vertices.resize(promised.vertices);
  memory->triangles.resize(promised.triangles);
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(payload.data());
  const ShellStatus status = memory->decoder.decode(bytes, payload.size(), memory->vertices.data(),
                                                    memory->triangles.data());
  if (status != ShellStatus::kOk) return bad_shell(promised, "the sample shell cannot be decoded.");
  LatticeMesh mesh{.resolution = form.lattice_resolution, .vertices = {}, .triangles = {}};
  mesh.vertices.reserve(promised.vertices);
  for (const shell::ShellVertex& v : memory->vertices) mesh.vertices.push_back({v.x, v.y, v.z});
  mesh.triangles.reserve(promised.triangles);
  for (const shell::ShellTriangle& t : memory->triangles) {
    mesh.triangles.push_back({t.corners[0], t.corners[1], t.corners[2]});
  }
  return mesh;
}

}  // namespace multitetra

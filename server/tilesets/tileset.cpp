#include "server/tilesets/tileset.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/hex_text.hpp"
#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/mesh/checksum.hpp"
#include "common/request/request_key.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

// Increase it when a cell's content changes for the same dataset.
constexpr const char* kCellForm = "3 ";

constexpr int kLeafExponent = 6;          // Smaller cells would be mostly border.
constexpr int kLargestWholeExponent = 8;  // Larger cells would cost more than a first preview.
constexpr int kStepsOfPreview = 6;        // At most 2^6 steps of its spacing a side.
constexpr double kMinCoarseError = 0.25;  // What the coarse levels multiply if leaves have less.
constexpr int kCellNormalBits = 8;

}  // namespace

Result<TilesetSettings> tileset_settings_from(std::string_view text) {
  constexpr std::string_view kError = "error=";
  constexpr std::string_view kCodec = "codec=";
  const auto refuse = [&](const std::string& what) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) + "\": " + what +
                    "; give an isovalue and optionally the error of the finest level in voxels "
                    "and the codec of 3D Tiles, such as 500.5 or 500.5,error=0.5,codec=meshopt.");
  };
  std::vector<std::string_view> parts;
  for (std::string_view rest = text;; rest.remove_prefix(parts.back().size() + 1)) {
    parts.push_back(rest.substr(0, rest.find(',')));
    if (parts.back().size() == rest.size()) break;
  }
  const auto isovalue = parse_finite(parts.front());
  if (!isovalue) return refuse("the isovalue is not a finite number");
  TilesetSettings settings{.isovalue = *isovalue};
  std::size_t at = 1;
  if (at < parts.size() && parts[at].starts_with(kError)) {
    const auto error = parse_finite(parts[at++].substr(kError.size()));
    if (!error || *error < 0) return refuse("the error is not a finite number of at least 0");
    settings.error = *error;
  }
  if (at < parts.size() && parts[at].starts_with(kCodec)) {
    const auto codec = kCellCodecs.find(parts[at++].substr(kCodec.size()));
    if (!codec) return refuse("the codec is not draco or meshopt");
    settings.codec = *codec;
  }
  if (at < parts.size()) return refuse("only error= and then codec= are allowed after the comma");
  return settings;
}

std::string text_of(const TilesetSettings& settings) {
  std::string text = shortest_text(settings.isovalue);
  if (settings.error != TilesetSettings{}.error) text += ",error=" + shortest_text(settings.error);
  if (settings.codec != TilesetSettings{}.codec) {
    text += ",codec=" + std::string(kCellCodecs.of(settings.codec));
  }
  return text;
}

std::string cell_name(const OctreeCube& cell) {
  return std::to_string(cell.exponent) + "-" + std::to_string(cell.x) + "-" +
         std::to_string(cell.y) + "-" + std::to_string(cell.z);
}

std::optional<OctreeCube> cell_from(std::string_view name) {
  const auto numbers = parse_numbers<std::int32_t>(name, 4, '-');
  if (!numbers) return std::nullopt;
  const OctreeCube cell{(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
  if (cell_name(cell) != name) return std::nullopt;
  return cell;
}

Tileset::Tileset(DatasetInfo info, const TilesetSettings& settings)
    : info_(std::move(info)), settings_(settings) {}

std::string Tileset::id() const {
  const std::string content = kCellForm + key_of(info_);
  return hex_text(checksum(std::as_bytes(std::span(content))));
}

int Tileset::leaf_exponent() const { return std::min(kLeafExponent, info_.grid_exponent); }

bool Tileset::contains(const OctreeCube& cell) const {
  if (cell.exponent < leaf_exponent() || cell.exponent > info_.grid_exponent) return false;
  const std::int32_t along = std::int32_t{1} << (info_.grid_exponent - cell.exponent);
  return std::min({cell.x, cell.y, cell.z}) >= 0 && std::max({cell.x, cell.y, cell.z}) < along;
}

bool Tileset::is_preview(int exponent) const {
  return exponent > leaf_exponent() &&
         (exponent == info_.grid_exponent || exponent > kLargestWholeExponent);
}

std::int32_t Tileset::finest_spacing(int exponent) const {
  if (!is_preview(exponent)) return 1;
  return std::max(kSpectrumSpacing, std::int32_t{1} << std::max(0, exponent - kStepsOfPreview));
}

int Tileset::lattice_resolution(int exponent) const {
  constexpr int kPreviewLatticeResolution = 3;  // Coarse tetrahedra need no fine lattice.
  return std::min(is_preview(exponent) ? kPreviewLatticeResolution : kDefaultLatticeResolution,
                  kMaxLatticeBits - info_.grid_exponent);
}

double Tileset::threshold(int exponent) const {
  if (exponent == leaf_exponent()) return settings_.error;
  // Four times as much for each level, so that cells of all levels have about as many triangles.
  const double coarse =
      std::ldexp(std::max(settings_.error, kMinCoarseError), 2 * (exponent - leaf_exponent()));
  return is_preview(exponent) ? std::max(coarse, finest_spacing(exponent) / 2.0) : coarse;
}

double Tileset::error_bound(int exponent) const {
  // Adds the rounding to the lattice, or features smaller than a preview's tetrahedra.
  const double step = is_preview(exponent)
                          ? static_cast<double>(finest_spacing(exponent))
                          : 1.0 / static_cast<double>(1 << lattice_resolution(exponent));
  return threshold(exponent) * voxel_length(info_) + step * longest_cell_diagonal(info_);
}

IsosurfaceRequest Tileset::request(const OctreeCube& cube, int level) const {
  const std::int32_t finest = finest_spacing(level);
  return {.isovalue = settings_.isovalue,
          .error = threshold(level),
          .topology_tolerance = is_preview(level) ? finest / 2.0 : 0,
          .lattice_resolution = lattice_resolution(level),
          .simplify = true,
          .cell = OctreeNode{.cube = cube, .finest_spacing = finest}};
}

IsosurfaceRequest Tileset::request(const OctreeCube& cell) const {
  IsosurfaceRequest request = this->request(cell, cell.exponent);
  request.normal_bits = kCellNormalBits;
  return request;
}

std::vector<IsosurfaceRequest> Tileset::fragment_requests(const OctreeCube& cell) const {
  if (is_leaf(cell)) return {request(cell, cell.exponent)};
  std::vector<IsosurfaceRequest> octants;
  for (int i = 0; i < 8; ++i) octants.push_back(request(cell.child(i), cell.exponent));
  return octants;
}

}  // namespace multitetra

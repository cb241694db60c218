// Builds the error spectrum of a volume, in memory that does not depend on the volume's size.
//
//   CoarseVolume coarse(info);  // Has seen all slices.
//   build_spectrum(info, bins, {.samples = boxes, .coarse = coarse, .scratch = scratch,
//                               .for_each = for_each, .threads = 2, .sink = sink});
//
// The volume is divided along all axes into columns. A column computes the curves of spacings 1, 2
// and 4, slice by slice, including a seam of six steps that its neighbours compute too, and stores
// those of the cube centers of spacing 4: one per cell of 8 x 8 x 8. From these and every eighth
// sample, the coarser levels are computed one after the other, each in blocks of bricks.
//
// Memory, not counting the scratch: the number and size of concurrent columns, and then of blocks,
// are chosen so that they fit into kMaxColumnBytes even if every point had errors in every bin.
// (The minimum is one: 37 MiB for a column with 256 bins, 110 MiB for a block.) In addition, 16
// bytes for each stored tile: at most 16 MiB for the largest grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxColumnBytes = std::size_t{384} << 20;

// Cells of kSpectrumSpacing grid steps, counted from the grid's origin; the end is exclusive.
struct CellBox {
  GridPoint begin;
  GridPoint end;

  friend bool operator==(const CellBox&, const CellBox&) = default;
};

struct SpectrumWork {
  const SampleBoxes& samples;
  const CoarseVolume& coarse;
  Scratch& scratch;
  ForEach for_each = sequentially;
  std::size_t threads = 1;  // The number of threads of for_each.
  std::size_t column_bytes = kMaxColumnBytes;
  // Receives the bytes of one brick of SpectrumLayout(info), each brick at most once and in an
  // order that does not depend on threads or memory. Bricks that it does not receive are empty.
  std::function<void(std::size_t brick, std::span<const std::byte> bytes)> sink;
  // Called from any thread with the number of further samples done.
  std::function<void(std::uint64_t samples)> progress = nullptr;
  // If known, the only cells in which the field is not constant; others have no errors.
  std::optional<CellBox> nonconstant_cells = std::nullopt;
};

// Computes the spectrum and passes its bricks to `work.sink`. The result does not depend on threads
// or memory.
void build_spectrum(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumWork& work);

// ---- in parts
//
// The curves of the cells in a box depend only on the samples of the box and within kSpectrumReach
// of it. So different machines can compute boxes independently; the coarser levels need them all.

// Returns the cells from whose curves a spectrum is built.
[[nodiscard]] CellBox spectrum_cells(const DatasetInfo& info);

// The curves of a box of cells; the bytes of the tiles are in a scratch.
struct CellCurves {
  CellBox cells;
  // The size of a tile in cells.
  GridPoint tile;
  // The ranges of the tiles in the scratch.
  std::vector<std::byte> tile_ranges;
};

// Writes the curves of these cells to work.scratch. The curves do not depend on threads, memory or
// boxes; their tile_ranges do.
[[nodiscard]] CellCurves make_cell_curves(const DatasetInfo& info, const IsovalueBins& bins,
                                          const SpectrumWork& work, const CellBox& cells);

struct SavedCurves {
  CellCurves curves;
  Scratch* scratch = nullptr;
};

// Performs build_spectrum() from the curves of the cells on: `parts` are boxes of them that
// together cover spectrum_cells(). Reads no samples. Throws std::runtime_error for damaged curves.
void build_spectrum_from(const DatasetInfo& info, const IsovalueBins& bins,
                         std::span<const SavedCurves> parts, const SpectrumWork& work);

}  // namespace multitetra

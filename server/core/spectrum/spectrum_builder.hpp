// Makes the error spectrum of a volume, in memory that is bounded whatever the volume.
//
//   CoarseVolume coarse(info);  // Has seen all slices.
//   build_spectrum(info, bins, {.samples = boxes, .coarse = coarse, .scratch = scratch,
//                               .for_each = for_each, .threads = 2, .sink = sink});
//
// The volume is cut along all axes into columns. A column computes the curves of spacings 1, 2 and
// 4 for itself, slice after slice, with a seam of six steps around it that is computed twice, and
// puts aside those of the cube centres of spacing 4: one per cell of 8 x 8 x 8. From these, and
// from every eighth sample, the coarser levels follow one after the other, each cut into blocks of
// bricks.
//
// Memory, beside what is in the scratch: as many columns are made at a time, and as large ones, as
// take kMostColumnBytes together in a volume in which every point has errors in every bin; and then
// as many blocks of bricks. (One at least: 37 MiB for a column with 256 bins, 110 MiB for a block.)
// And 16 bytes for each tile that is put aside: at most 16 MiB for the largest grid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/request/dataset_info.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

inline constexpr std::size_t kMostColumnBytes = std::size_t{384} << 20;

// Cells of kSpectrumSpacing grid steps, numbered from the grid's origin; the end is exclusive.
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
  std::size_t threads = 1;  // That for_each uses.
  std::size_t column_bytes = kMostColumnBytes;
  // Takes the bytes of one brick of SpectrumLayout(info). Each brick at most once and always in the
  // same order, whatever the threads and the memory; those that are never taken are empty.
  std::function<void(std::size_t brick, std::span<const std::byte> bytes)> sink;
  // Called with the number of further samples done, from any of the threads.
  std::function<void(std::uint64_t samples)> progress = nullptr;
  // The only cells for which more than one value counts, where that is known; others have no
  // errors.
  std::optional<CellBox> varied_cells = std::nullopt;
};

// The same for any threads and memory.
void build_spectrum(const DatasetInfo& info, const IsovalueBins& bins, const SpectrumWork& work);

// ---- in parts
//
// The curves of the cells in a box need the samples of the box and kSpectrumReach around it, and
// nothing of other boxes. So machines can make them apart; the coarser levels need them all.

// The cells whose curves a spectrum is made from.
[[nodiscard]] CellBox spectrum_cells(const DatasetInfo& info);

// The curves of a box of cells; the bytes of each tile of cells are in a scratch.
struct CellCurves {
  CellBox cells;
  GridPoint tile;                 // Cells along a tile.
  std::vector<std::byte> places;  // The places of tiles in the scratch file.
};

// Puts the curves of these cells into work.scratch. The curves are the same for any threads,
// memory and boxes; their places are not.
[[nodiscard]] CellCurves make_cell_curves(const DatasetInfo& info, const IsovalueBins& bins,
                                          const SpectrumWork& work, const CellBox& cells);

struct SavedCurves {
  CellCurves curves;
  Scratch* scratch = nullptr;
};

// What build_spectrum() does after the curves of the cells are made: here boxes of them, which
// together are spectrum_cells(). No sample is read. Throws std::runtime_error when curves are
// damaged.
void build_spectrum_from(const DatasetInfo& info, const IsovalueBins& bins,
                         std::span<const SavedCurves> parts, const SpectrumWork& work);

}  // namespace multitetra

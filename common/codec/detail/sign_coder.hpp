// Codes a field of bits: which samples are positive, or which are not void.
//
// Blocks of 4^3 samples are all zeros, all ones or mixed, in the order z, y, x; the context is the
// blocks to the left, in front and below. The samples of mixed blocks follow, row by row; the
// context is twelve neighbours that are already known (x: the sample):
//
//   slice z - 2      slice z - 1          slice z
//       .                o                   o          y - 2, y - 1 and y from top to bottom;
//       .              o o o               o o o        the slice before also has y + 1 below
//       o                o              o o x
//
// Missing rows and slices are replaced by the nearest existing ones; README.md has the rules.
#pragma once

#include <stdint.h>

#include "common/codec/detail/row_bits.hpp"
#include "common/codec/detail/shell_model.hpp"

namespace multitetra::shell {

// The kinds of the blocks, numbered as in RowFilling.
struct SignBlocks {
  static constexpr int kSide = (kMaxShellSamples + 3) / 4;
  uint8_t kinds[kSide][kSide][kSide];  // [z][y][x]
};

// Returns the kind of a block; `any` and `all` are the disjunction and conjunction of its rows.
[[nodiscard]] inline uint8_t kind_of_block(RowBits any, RowBits all, int block, int samples) {
  const uint32_t inside = samples < 4 ? (1U << samples) - 1 : 15U;
  if ((bits_from(any, 4 * block + 1) & inside) == 0) return 0;
  return (bits_from(all, 4 * block + 1) & inside) == inside ? 1 : 2;
}

// Codes the kinds of blocks. When decoding, requires a cleared `field` and sets the bits of the
// blocks of ones.
template <typename Coder>
void code_blocks(Coder& coder, SignModel& model, SignBlocks& blocks, BitField& field) {
  const int counts[3] = {(field.size(0) + 3) / 4, (field.size(1) + 3) / 4, (field.size(2) + 3) / 4};
  for (int k = 0; k < counts[2]; ++k) {
    const int end_z = 4 * k + 4 < field.size(2) ? 4 * k + 4 : field.size(2);
    for (int j = 0; j < counts[1]; ++j) {
      const int end_y = 4 * j + 4 < field.size(1) ? 4 * j + 4 : field.size(1);
      RowBits any;
      RowBits all = field.inside();
      if constexpr (Coder::kEncodes) {
        for (int z = 4 * k; z < end_z; ++z) {
          for (int y = 4 * j; y < end_y; ++y) {
            any |= field.row(y, z);
            all = all & field.row(y, z);
          }
        }
      }
      RowBits ones;
      uint8_t* const row = blocks.kinds[k][j];
      for (int i = 0; i < counts[0]; ++i) {
        const int before_y = j > 0 ? blocks.kinds[k][j - 1][i] : -1;
        const int before_z = k > 0 ? blocks.kinds[k - 1][j][i] : -1;
        const int left = i > 0 ? row[i - 1] : j > 0 ? before_y : k > 0 ? before_z : 0;
        const int front = j > 0 ? before_y : left;
        const int below = k > 0 ? before_z : front;
        const int diagonal = j > 0 && k > 0 ? blocks.kinds[k - 1][j - 1][i] : 3;
        const int context = ((left * 3 + front) * 3 + below) * 4 + diagonal;
        int kind = 0;
        if constexpr (Coder::kEncodes) kind = kind_of_block(any, all, i, field.size(0) - 4 * i);
        if (coder.bit(model.block_is_mixed[context], kind == 2)) {
          kind = 2;
        } else {
          kind = coder.bit(model.block_is_ones[context], kind == 1) ? 1 : 0;
        }
        row[i] = static_cast<uint8_t>(kind);
        if (kind == 1) ones |= samples_from_to(4 * i, 4 * i + 4);
      }
      if constexpr (!Coder::kEncodes) {
        if (!ones.any()) continue;
        for (int z = 4 * k; z < end_z; ++z) {
          for (int y = 4 * j; y < end_y; ++y) field.row(y, z) = ones & field.inside();
        }
      }
    }
  }
}

// The rows around the row being coded, with their margins.
struct RowsAround {
  static constexpr RowBits kNone = {};
  const RowBits* before_y = &kNone;   // y - 1
  const RowBits* before_y2 = &kNone;  // y - 2
  const RowBits* before_z = &kNone;   // z - 1
  const RowBits* before_z2 = &kNone;  // z - 2
  const RowBits* before_yz = &kNone;  // y - 1, z - 1
  const RowBits* behind_yz = &kNone;  // y + 1, z - 1

  RowsAround(const BitField& field, int y, int z) {
    if (y == 0 && z == 0) return;
    before_y = &field.row(y > 0 ? y - 1 : y, y > 0 ? z : z - 1);
    before_z = z > 0 ? &field.row(y, z - 1) : before_y;
    before_y2 = y > 1 ? &field.row(y - 2, z) : before_y;
    before_z2 = z > 1 ? &field.row(y, z - 2) : before_z;
    before_yz = y > 0 && z > 0 ? &field.row(y - 1, z - 1) : before_y;
    behind_yz = z > 0 && y + 1 < field.size(1) ? &field.row(y + 1, z - 1) : before_z;
  }
};

// Codes the samples of one row's mixed blocks.
template <typename Coder>
void code_row(Coder& coder, SignModel& model, const uint8_t* kinds, BitField& field, int y, int z) {
  const RowsAround around(field, y, z);
  RowBits& row = field.row(y, z);
  const int nx = field.size(0);
  for (int block = 0; 4 * block < nx; ++block) {
    if (kinds[block] != 2) continue;
    const int first = 4 * block;
    const int end = first + 4 < nx ? first + 4 : nx;
    // The lowest bit belongs to the sample before the first one, or to the first one.
    uint32_t y1 = bits_from(*around.before_y, first);
    uint32_t z1 = bits_from(*around.before_z, first);
    uint32_t y2 = bits_from(*around.before_y2, first + 1);
    uint32_t z2 = bits_from(*around.before_z2, first + 1);
    uint32_t yz = bits_from(*around.before_yz, first + 1);
    uint32_t zy = bits_from(*around.behind_yz, first + 1);
    uint32_t left = 0;  // Bit 0: x - 2, bit 1: x - 1.
    if (first > 0) {
      left = bits_from(row, first - 1) & 3U;
    } else {
      left = (y1 >> 1 & 1U) * 3U;
    }
    uint32_t known = Coder::kEncodes ? bits_from(row, first + 1) : 0;
    uint32_t coded = 0;
    for (int x = first; x < end; ++x) {
      const uint32_t context = left | (y1 & 7U) << 2 | (z1 & 7U) << 5 | (y2 & 1U) << 8 |
                               (z2 & 1U) << 9 | (yz & 1U) << 10 | (zy & 1U) << 11;
      const uint32_t one = coder.bit(model.sample[context], (known & 1U) != 0) ? 1U : 0U;
      coded |= one << (x - first);
      left = left >> 1 | one << 1;
      y1 >>= 1;
      z1 >>= 1;
      y2 >>= 1;
      z2 >>= 1;
      yz >>= 1;
      zy >>= 1;
      known >>= 1;
    }
    if constexpr (!Coder::kEncodes) {
      const int bit = first + 1;
      if (bit < 64) row.low |= uint64_t{coded} << bit;
      if (bit > 60)
        row.high |= bit < 64 ? uint64_t{coded} >> (64 - bit) : uint64_t{coded} << (bit - 64);
    }
  }
}

// Codes a field. When encoding, requires all bits and margins; when decoding, only the size, and
// sets everything else.
template <typename Coder>
void code_signs(Coder& coder, SignModel& model, SignBlocks& blocks, BitField& field) {
  code_blocks(coder, model, blocks, field);
  for (int z = 0; z < field.size(2); ++z) {
    for (int y = 0; y < field.size(1); ++y) {
      code_row(coder, model, blocks.kinds[z / 4][y / 4], field, y, z);
      if constexpr (!Coder::kEncodes) field.fill_row_margins(y, z);
    }
  }
  if constexpr (!Coder::kEncodes) field.finish();
}

}  // namespace multitetra::shell

// One bit for each sample of a box: whether it is positive, not void, or active.
//
// A row has 128 bits. Bit x + 1 stands for sample x; bit 0 and the bit after the last sample are
// margins, which repeat the row's ends:
//
//   bit      0   1   2   3  ...  n   n+1
//   sample   0   0   1   2  ... n-1  n-1
//
// A field of rows has margins in y and z, too. So every sample has neighbours, and three in a row
// are one load. Like all headers of the decoder, this one needs only a compiler.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "common/codec/shell_format.hpp"

namespace multitetra::shell {

struct RowBits {
  uint64_t low = 0;
  uint64_t high = 0;

  [[nodiscard]] constexpr bool any() const { return (low | high) != 0; }

  constexpr RowBits& operator|=(RowBits b) {
    low |= b.low;
    high |= b.high;
    return *this;
  }
  friend constexpr RowBits operator|(RowBits a, RowBits b) {
    return {a.low | b.low, a.high | b.high};
  }
  friend constexpr RowBits operator&(RowBits a, RowBits b) {
    return {a.low & b.low, a.high & b.high};
  }
  friend constexpr RowBits operator^(RowBits a, RowBits b) {
    return {a.low ^ b.low, a.high ^ b.high};
  }
  friend constexpr RowBits operator~(RowBits a) { return {~a.low, ~a.high}; }
  friend constexpr bool operator==(RowBits a, RowBits b) {
    return a.low == b.low && a.high == b.high;
  }
};

// Returns a row whose bit i is bit i + 1 of `row`: that of the next sample.
[[nodiscard]] constexpr RowBits of_next(RowBits row) {
  return {row.low >> 1 | row.high << 63, row.high >> 1};
}
// Returns a row whose bit i is bit i - 1 of `row`: that of the previous sample.
[[nodiscard]] constexpr RowBits of_previous(RowBits row) {
  return {row.low << 1, row.high << 1 | row.low >> 63};
}

// Returns a row with the bits of samples first .. end - 1.
[[nodiscard]] constexpr RowBits samples_from_to(int first, int end) {
  const auto below = [](int bit) -> RowBits {
    if (bit >= 64) return {~uint64_t{0}, (uint64_t{1} << (bit - 64)) - 1};
    return {(uint64_t{1} << bit) - 1, 0};
  };
  return end <= first ? RowBits{} : below(end + 1) & ~below(first + 1);
}

// Calls visit(x) for the samples whose bit is set, in ascending order.
template <typename Visit>
inline void for_each_sample(RowBits row, const Visit& visit) {
  for (uint64_t rest = row.low; rest != 0; rest &= rest - 1) visit(__builtin_ctzll(rest) - 1);
  for (uint64_t rest = row.high; rest != 0; rest &= rest - 1) visit(__builtin_ctzll(rest) + 63);
}

[[nodiscard]] inline int count(RowBits row) {
  return __builtin_popcountll(row.low) + __builtin_popcountll(row.high);
}

// Returns at least 25 of the row's bits, starting at `bit`.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "A row's bytes hold its bits in order.");
[[nodiscard]] inline uint32_t bits_from(const RowBits& row, int bit) {
  uint32_t word = 0;
  __builtin_memcpy(&word, reinterpret_cast<const unsigned char*>(&row) + (bit >> 3), sizeof(word));
  return word >> (bit & 7);
}

// What a row holds: all bits clear, all set, or mixed.
enum class RowFilling : uint8_t { kZeros = 0, kOnes = 1, kMixed = 2 };

class BitField {
 public:
  // Clears all bits. Every size is 1 .. kMaxShellSamples.
  void begin(int nx, int ny, int nz) {
    size_[0] = nx;
    size_[1] = ny;
    size_[2] = nz;
    inside_ = samples_from_to(0, nx);
    for (int z = 0; z < nz; ++z) {
      for (int y = 0; y < ny; ++y) row(y, z) = {};
    }
  }

  [[nodiscard]] int size(int axis) const { return size_[axis]; }
  [[nodiscard]] RowBits inside() const { return inside_; }
  // y from -1 to size(1), z from -1 to size(2); margins are valid after finish().
  [[nodiscard]] RowBits& row(int y, int z) { return rows_[z + 1][y + 1]; }
  [[nodiscard]] const RowBits& row(int y, int z) const { return rows_[z + 1][y + 1]; }
  [[nodiscard]] RowFilling kind(int y, int z) const { return kinds_[z][y]; }
  [[nodiscard]] bool at(int x, int y, int z) const {
    return (bits_from(row(y, z), x + 1) & 1U) != 0;
  }

  // Repeats the ends of a row whose samples are set.
  void fill_row_margins(int y, int z) {
    const int nx = size_[0];
    RowBits& bits = row(y, z);
    bits = bits & inside_;
    bits |= RowBits{bits.low >> 1 & 1U, 0};
    bits |= of_previous(bits & samples_from_to(nx - 1, nx));
  }

  // Fills all margins and determines the kinds of rows.
  void finish() {
    for (int z = 0; z < size_[2]; ++z) {
      for (int y = 0; y < size_[1]; ++y) {
        fill_row_margins(y, z);
        const RowBits bits = row(y, z) & inside_;
        kinds_[z][y] = !bits.any()       ? RowFilling::kZeros
                       : bits == inside_ ? RowFilling::kOnes
                                         : RowFilling::kMixed;
      }
      row(-1, z) = row(0, z);
      row(size_[1], z) = row(size_[1] - 1, z);
    }
    for (int y = -1; y <= size_[1]; ++y) {
      row(y, -1) = row(y, 0);
      row(y, size_[2]) = row(y, size_[2] - 1);
    }
  }

  // Moves the box into a larger one: samples keep their bits and are shifted by `low` along the
  // axes; all others get the bit `around`. Margins must be filled afterwards.
  void enclose(const int (&low)[3], const int (&size)[3], bool around) {
    const int old_size[3] = {size_[0], size_[1], size_[2]};
    const RowBits old_inside = inside_;
    for (int axis = 0; axis < 3; ++axis) size_[axis] = size[axis];
    inside_ = samples_from_to(0, size[0]);
    const RowBits moved_inside = low[0] != 0 ? of_previous(old_inside) : old_inside;
    const RowBits fill = around ? inside_ & ~moved_inside : RowBits{};
    // In descending order, so that no row is overwritten before it is moved.
    for (int z = size[2] - 1; z >= 0; --z) {
      for (int y = size[1] - 1; y >= 0; --y) {
        const int old_y = y - low[1];
        const int old_z = z - low[2];
        if (old_y < 0 || old_z < 0 || old_y >= old_size[1] || old_z >= old_size[2]) {
          row(y, z) = around ? inside_ : RowBits{};
        } else {
          const RowBits bits = row(old_y, old_z) & old_inside;
          row(y, z) = (low[0] != 0 ? of_previous(bits) : bits) | fill;
        }
      }
    }
  }

 private:
  int size_[3] = {0, 0, 0};
  RowBits inside_;
  RowBits rows_[kMaxShellSamples + 2][kMaxShellSamples + 2];
  RowFilling kinds_[kMaxShellSamples][kMaxShellSamples];
};

// The samples of a box that belong to the data, not to layers beyond it.
class DataBox {
 public:
  explicit DataBox(const ShellHeader& header)
      : in_row_(samples_from_to(header.layer(0, false), header.samples[0] - header.layer(0, true))),
        first_y_(header.layer(1, false)),
        end_y_(header.samples[1] - header.layer(1, true)),
        first_z_(header.layer(2, false)),
        end_z_(header.samples[2] - header.layer(2, true)) {}

  [[nodiscard]] RowBits row(int y, int z) const {
    return y >= first_y_ && y < end_y_ && z >= first_z_ && z < end_z_ ? in_row_ : RowBits{};
  }

 private:
  RowBits in_row_;
  int first_y_;
  int end_y_;
  int first_z_;
  int end_z_;
};

}  // namespace multitetra::shell

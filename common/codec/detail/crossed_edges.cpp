#include "common/codec/detail/crossed_edges.hpp"

namespace multitetra::shell {

void CrossedEdges::begin(const BitField& signs, const BitField* present,
                         const int32_t (&origin)[3]) {
  signs_ = &signs;
  present_ = present;
  for (int axis = 0; axis < 3; ++axis) origin_[axis] = origin[axis];
  const int nx = signs.size(0);
  inside_ = signs.inside();
  not_last_ = samples_from_to(0, nx - 1);
  not_first_ = samples_from_to(1, nx);
  // Sample x is bit x + 1.
  const uint64_t even = (origin[0] & 1) == 0 ? 0xaaaaaaaaaaaaaaaaU : 0x5555555555555555U;
  even_ = {even, even};
  for (int slice = 0; slice < 2; ++slice) {
    for (int y = 0; y < signs.size(1); ++y) {
      any_[slice][y] = true;  // Makes find() clear the previous tile's rows.
      active_[slice][y] = {};
    }
  }
}

bool CrossedEdges::is_uniform_around(int y, int z) const {
  const RowFilling kind = signs_->kind(y, z);
  if (kind == RowFilling::kMixed) return false;
  const int next_y = y + 1 < signs_->size(1) ? y + 1 : y;
  const int next_z = z + 1 < signs_->size(2) ? z + 1 : z;
  const int before_y = y > 0 ? y - 1 : y;
  return signs_->kind(next_y, z) == kind && signs_->kind(y, next_z) == kind &&
         signs_->kind(next_y, next_z) == kind && signs_->kind(before_y, next_z) == kind;
}

template <bool kHasVoid>
void CrossedEdges::find_in_row(int y, int z) {
  RowBits* const crossed = crossed_[z & 1][y];
  RowBits& active = active_[z & 1][y];
  const RowBits from = signs_->row(y, z);
  const RowBits there = kHasVoid ? presence(y, z) & inside_ : inside_;
  RowBits any;

  RowBits along_x = (from ^ of_next(from)) & not_last_;
  if constexpr (kHasVoid) along_x = along_x & there & of_next(there);
  crossed[0] = along_x;
  any |= along_x;
  active |= along_x | of_previous(along_x);

  const auto find_to = [&](int to_y, int to_z, int direction) {
    const RowBits to = signs_->row(to_y, to_z);
    const RowBits to_there = kHasVoid ? presence(to_y, to_z) & inside_ : inside_;
    RowBits& to_active = active_[to_z & 1][to_y];
    // Face diagonals in planes across y or z, and cube diagonals: they exist where x has the parity
    // of the changing coordinate.
    const int parity = to_y != y ? y + origin_[1] : z + origin_[2];
    const RowBits diagonals = (parity & 1) == 0 ? even_ : ~even_;
    RowBits straight = (from ^ to) & inside_;
    RowBits up = (from ^ of_next(to)) & not_last_ & diagonals;
    RowBits down = (from ^ of_previous(to)) & not_first_ & diagonals;
    if constexpr (kHasVoid) {
      straight = straight & there & to_there;
      up = up & there & of_next(to_there);
      down = down & there & of_previous(to_there);
    }
    crossed[direction] = straight;
    crossed[direction + 1] = up;
    crossed[direction + 2] = down;
    const RowBits all = straight | up | down;
    any |= all;
    active |= all;
    to_active |= straight | of_previous(up) | of_next(down);
  };
  const bool has_next_y = y + 1 < signs_->size(1);
  if (has_next_y) find_to(y + 1, z, 1);
  if (z + 1 < signs_->size(2)) {
    find_to(y, z + 1, 4);
    if (((y + origin_[1]) ^ (z + origin_[2])) % 2 == 0) {
      if (has_next_y) find_to(y + 1, z + 1, 7);
      if (y > 0) find_to(y - 1, z + 1, 10);
    }
  }
  any_[z & 1][y] = any.any();
}

void CrossedEdges::find(int z) {
  const int ny = signs_->size(1);
  for (int y = 0; y < ny; ++y) active_[(z + 1) & 1][y] = {};
  for (int y = 0; y < ny; ++y) {
    bool& has_any = any_[z & 1][y];
    if (has_any) {
      for (RowBits& row : crossed_[z & 1][y]) row = {};
      has_any = false;
    }
    if (is_uniform_around(y, z)) continue;
    if (present_ == nullptr) {
      find_in_row<false>(y, z);
    } else {
      find_in_row<true>(y, z);
    }
  }
}

}  // namespace multitetra::shell

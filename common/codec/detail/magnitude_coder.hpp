// Codes the magnitudes |v - c| of active samples, in the order z, y, x: predicts them from already
// coded neighbours and from the signs of later ones, and codes the residuals.
//
// A magnitude m >= 0 is an integer: for exact samples the number of integers between v and the
// isovalue, for others LevelScale::magnitude. Predictions use w = +-(2 m + 1), positive for
// positive samples. Of the seven neighbours before a sample
//
//   0: x - 1    1: y - 1    2: z - 1    3: x, y - 1    4: x, z - 1    5: y, z - 1    6: x, y, z - 1
//
// active ones contribute their w, others +-g by their sign, where g is the mean |w| of the active
// ones. The three next neighbours along the axes and the sample itself contribute +-g, too. The
// weights depend on which of the seven are active.
#pragma once

#include <stdint.h>

#include "common/codec/detail/level_scale.hpp"
#include "common/codec/detail/powers_of_two.hpp"
#include "common/codec/detail/row_bits.hpp"
#include "common/codec/detail/shell_model.hpp"
#include "common/codec/detail/trained_tables.hpp"

namespace multitetra::shell {

[[nodiscard]] constexpr int clamped(int v, int low, int high) {
  return v < low ? low : v > high ? high : v;
}

// An active sample of slice z - 1 or z. Samples that are not active, or lie in a layer beyond the
// data or in a margin, are all zeros.
struct KnownSample {
  int32_t w = 0;
  int32_t missed = 0;  // |m - prediction|, at most kMaxMagnitude.
};

struct SampleRings {
  static constexpr int kRow = kMaxShellSamples + 2;

  // Returns a sample or margin of a slice; x and y start at -1.
  [[nodiscard]] KnownSample* known(int y, int z) { return known_[z & 1] + (y + 1) * kRow + 1; }
  // The input of marching at active samples and layers: values of exact shells, levels of others.
  [[nodiscard]] float* values(int y, int z) { return values_[z & 1] + y * kRow; }
  [[nodiscard]] int32_t* levels(int y, int z) { return levels_[z & 1] + y * kRow; }

  void begin() {
    for (auto& slice : known_) {
      for (KnownSample& sample : slice) sample = {};
    }
    for (auto& slice : is_used_) {
      for (bool& used : slice) used = false;
    }
  }
  void begin_slice(int z, int ny) {
    for (int y = 0; y < ny; ++y) {
      bool& used = is_used_[z & 1][y];
      if (!used) continue;
      for (int x = 0; x < kMaxShellSamples; ++x) known(y, z)[x] = {};
      used = false;
    }
  }
  void use_row(int y, int z) { is_used_[z & 1][y] = true; }

 private:
  KnownSample known_[2][kRow * kRow];
  float values_[2][kRow * kRow];
  int32_t levels_[2][kRow * kRow];
  bool is_used_[2][kMaxShellSamples];
};

// The indices of weights: 0 to 6 for the neighbours, 7 to 9 for the next samples along x, y, z, 10
// for the sample itself; in units of 2^-8.
inline constexpr int kWeights = 11;

// The means around a sample weigh neighbours by 8 along axes, 3 along face diagonals and 1 along
// the cube diagonal.
struct PredictionContext {
  uint64_t reciprocal = 0;  // ceil(2^32 / weight): x / weight is x * this >> 32 for x < 2^26.
  uint8_t weight = 0;
  // Class of the number of neighbours: 0 for none, 1 for 1-2, 2 for 3-4, 3 for more.
  uint8_t kind = 0;
};
struct PredictionContexts {
  PredictionContext of[128];
};
[[nodiscard]] constexpr PredictionContexts make_contexts() {
  constexpr uint32_t kWeight[7] = {8, 8, 8, 3, 3, 3, 1};
  PredictionContexts supports{};
  for (unsigned mask = 1; mask < 128; ++mask) {
    uint32_t weight = 0;
    int neighbours = 0;
    for (unsigned i = 0; i < 7; ++i) {
      if ((mask >> i & 1U) == 0) continue;
      weight += kWeight[i];
      ++neighbours;
    }
    supports.of[mask] = {.reciprocal = ((uint64_t{1} << 32) + weight - 1) / weight,
                         .weight = static_cast<uint8_t>(weight),
                         .kind = static_cast<uint8_t>(neighbours < 3   ? 1
                                                      : neighbours < 5 ? 2
                                                                       : 3)};
  }
  return supports;
}
inline constexpr PredictionContexts kContexts = make_contexts();

// Running means, for samples without active neighbours.
struct RunningMeans {
  int32_t w = 16;
  int32_t missed = 8;  // Twice the mean.
};

// The inputs of a prediction, which is their weighted sum.
struct Inputs {
  unsigned mask = 0;  // One bit for each active neighbour.
  bool is_positive = false;
  int32_t g = 0;
  int32_t missed = 0;  // Twice the neighbours' mean error.
  int32_t of[kWeights];
};

struct Prediction {
  int32_t magnitude = 0;  // >= 0
  int32_t scale = 0;      // Its typical error, approximately.
  int support = 0;        // 0 to 3.
};

// The rows of signs around a sample.
struct SignsAround {
  const RowBits* here;
  const RowBits* before_y;
  const RowBits* before_z;
  const RowBits* before_yz;
  const RowBits* next_y;
  const RowBits* next_z;

  SignsAround(const BitField& signs, int y, int z)
      : here(&signs.row(y, z)),
        before_y(&signs.row(y - 1, z)),
        before_z(&signs.row(y, z - 1)),
        before_yz(&signs.row(y - 1, z - 1)),
        next_y(&signs.row(y + 1, z)),
        next_z(&signs.row(y, z + 1)) {}
};

// `current` and `before` point to the sample in its slice and in the previous one.
[[nodiscard]] inline Inputs inputs_around(const SignsAround& signs, int x,
                                          const KnownSample* current, const KnownSample* before,
                                          const RunningMeans& recent) {
  constexpr int kRow = SampleRings::kRow;
  const KnownSample known[7] = {current[-1], current[-kRow], before[0],        current[-kRow - 1],
                                before[-1],  before[-kRow],  before[-kRow - 1]};
  const auto size = [](int32_t v) { return v < 0 ? -v : v; };
  Inputs inputs;
  inputs.g = recent.w;
  inputs.missed = recent.missed;
  for (unsigned i = 0; i < 7; ++i) {
    // In one expression, GCC 12 with its sanitizer reads another element.
    const bool is_active = known[i].w != 0;
    inputs.mask |= (is_active ? 1U : 0U) << i;
  }
  if (inputs.mask != 0) {
    const PredictionContext& support = kContexts.of[inputs.mask];
    const auto mean = [&support](int32_t sum) {
      return static_cast<int32_t>(static_cast<uint32_t>(sum) * support.reciprocal >> 32);
    };
    inputs.g = mean(8 * (size(known[0].w) + size(known[1].w) + size(known[2].w)) +
                    3 * (size(known[3].w) + size(known[4].w) + size(known[5].w)) +
                    size(known[6].w) + support.weight / 2);
    inputs.missed =
        mean(2 * (8 * (known[0].missed + known[1].missed + known[2].missed) +
                  3 * (known[3].missed + known[4].missed + known[5].missed) + known[6].missed));
  }

  const uint32_t row = bits_from(*signs.here, x);  // x - 1, x, x + 1
  const uint32_t row_y = bits_from(*signs.before_y, x);
  const uint32_t row_z = bits_from(*signs.before_z, x);
  const uint32_t row_yz = bits_from(*signs.before_yz, x);
  const uint32_t next_y = bits_from(*signs.next_y, x + 1);
  const uint32_t next_z = bits_from(*signs.next_z, x + 1);
  const uint32_t bits[kWeights] = {row,    row_y >> 1, row_z >> 1, row_y,  row_z,   row_yz >> 1,
                                   row_yz, row >> 2,   next_y,     next_z, row >> 1};
  inputs.is_positive = (row & 2U) != 0;
  for (int i = 0; i < kWeights; ++i) {
    const int32_t with_sign = (bits[i] & 1U) != 0 ? inputs.g : -inputs.g;
    inputs.of[i] = i < 7 && known[i].w != 0 ? known[i].w : with_sign;
  }
  return inputs;
}

[[nodiscard]] inline Prediction predict(const Inputs& inputs) {
  int32_t sum = 128;
  for (int i = 0; i < kWeights; ++i) sum += kTrainedWeights[inputs.mask][i] * inputs.of[i];
  const int32_t magnitude = (inputs.is_positive ? sum : -sum) >> 9;
  return {.magnitude = magnitude < 0 ? 0 : magnitude,
          .scale = inputs.missed + (inputs.g >> 2),
          .support = kContexts.of[inputs.mask].kind};
}

// Codes a residual: whether it is 0, its sign, its number of bits, and these bits. `place` is the
// class of the prediction's distance to 0; `can_be_less`: the residual can be negative.
template <typename Coder>
[[nodiscard]] int32_t code_residual(Coder& coder, ValueModel& model, int32_t residual, int context,
                                    int place, bool can_be_less) {
  constexpr int kMaxBits = 26;
  constexpr int kModelled = 2;  // The number of bits after the first that are worth modelling.
  if (!coder.bit(model.is_missed[context][place], residual != 0)) return 0;
  const bool is_less = can_be_less && coder.bit(model.is_too_high[context][place], residual < 0);
  const auto size = static_cast<uint32_t>(residual < 0 ? -residual : residual);
  const int sign = is_less ? 1 : 0;
  const int known_bits = Coder::kEncodes ? floor_log2(size) : 0;
  int bits = 0;  // The number of bits after the first.
  Probability* const is_longer = model.is_longer[context][sign];
  const auto at = [](int i) { return i < ValueModel::kExponents ? i : ValueModel::kExponents - 1; };
  while (bits < kMaxBits && coder.bit(is_longer[at(bits)], bits < known_bits)) ++bits;
  uint32_t value = 1;
  int remaining_bits = bits;
  Probability* const mantissa = model.mantissa[at(bits)][sign];
  for (int i = 0; i < kModelled && remaining_bits > 0; ++i) {
    --remaining_bits;
    const int node = i == 0 ? 0 : 1 + static_cast<int>(value & 1U);
    value = value << 1 | (coder.bit(mantissa[node], (size >> remaining_bits & 1U) != 0) ? 1U : 0U);
  }
  if (remaining_bits > 0)
    value = value << remaining_bits |
            coder.raw_bits(remaining_bits, size & ((1U << remaining_bits) - 1));
  return is_less ? -static_cast<int32_t>(value) : static_cast<int32_t>(value);
}

// Magnitudes of exact integers: m = v - floor(c) - 1 above the isovalue, floor(c) - v below.
class ExactMagnitudes {
 public:
  static constexpr int32_t kMax = (1 << 25) - 1;

  [[nodiscard]] static RunningMeans start() { return {.w = 16, .missed = 8}; }

  // Codes a magnitude; returns it, and the number to predict from.
  template <typename Coder>
  int32_t code(Coder& coder, ValueModel& model, const Prediction& prediction, int32_t magnitude,
               int32_t& for_predictions) const {
    const int32_t predicted = prediction.magnitude;
    const int32_t scale = prediction.scale;
    const int context =
        clamped(half_octaves(static_cast<uint32_t>(scale)), 0, ValueModel::kScales - 1) *
            ValueModel::kSupports +
        prediction.support;
    const int place = predicted == 0          ? 0
                      : predicted * 8 < scale ? 1
                      : predicted * 4 < scale ? 2
                      : predicted * 2 < scale ? 3
                      : predicted < scale     ? 4
                                              : 5;
    const int32_t coded = predicted + code_residual(coder, model, magnitude - predicted, context,
                                                    place, predicted > 0);
    const int32_t bounded = coded < 0 ? 0 : coded > kMax ? kMax : coded;
    for_predictions = bounded < kMaxMagnitude ? bounded : kMaxMagnitude;
    return bounded;
  }
};

// Magnitudes as level numbers.
class LevelMagnitudes {
 public:
  explicit LevelMagnitudes(const LevelScale& scale) : scale_(scale) {}

  [[nodiscard]] static RunningMeans start() { return {.w = 2048, .missed = 512}; }

  template <typename Coder>
  int32_t code(Coder& coder, ValueModel& model, const Prediction& prediction, int32_t level,
               int32_t& for_predictions) const {
    // The logarithm of a prediction near 0 is no useful context; uses the typical residual instead.
    const int32_t least = prediction.scale / 8;
    const int32_t magnitude = prediction.magnitude < least ? least : prediction.magnitude;
    const int32_t predicted = scale_.level(magnitude);
    // The typical error in levels, approximately scale / magnitude * L.
    const int relative = half_octaves(static_cast<uint32_t>(prediction.scale)) -
                         half_octaves(static_cast<uint32_t>(magnitude)) +
                         scale_.half_octaves_of_levels() + 8;
    const int context =
        clamped(relative, 0, ValueModel::kScales - 1) * ValueModel::kSupports + prediction.support;
    const int place =
        clamped(predicted * 2 >> scale_.half_octaves_of_levels() / 2, 0, ValueModel::kPlaces - 1);
    const int32_t coded =
        predicted + code_residual(coder, model, level - predicted, context, place, predicted > 0);
    const int32_t bounded = coded < 0 ? 0 : coded >= scale_.levels() ? scale_.levels() - 1 : coded;
    for_predictions = scale_.magnitude(bounded);
    return bounded;
  }

 private:
  const LevelScale& scale_;
};

// Codes the active samples of a row. When encoding, `next()` returns the next magnitude or level;
// `keep(x, m)` receives each coded one.
template <typename Coder, typename Magnitudes, typename Next, typename Keep>
void code_row_of_samples(Coder& coder, ValueModel& model, const Magnitudes& magnitudes,
                         const BitField& signs, RowBits coded, int y, int z, SampleRings& rings,
                         RunningMeans& recent, const Next& next, const Keep& keep) {
  if (!coded.any()) return;
  rings.use_row(y, z);
  const SignsAround around(signs, y, z);
  KnownSample* const current = rings.known(y, z);
  const KnownSample* const before = rings.known(y, z - 1);
  for_each_sample(coded, [&](int x) {
    const Prediction prediction =
        predict(inputs_around(around, x, current + x, before + x, recent));
    int32_t m = 0;
    keep(x, magnitudes.code(coder, model, prediction, next(), m));
    const int32_t off = m - prediction.magnitude;
    const int32_t missed = clamped(off < 0 ? -off : off, 0, kMaxMagnitude);
    const int32_t w = 2 * m + 1;
    const bool is_positive = (bits_from(*around.here, x + 1) & 1U) != 0;
    current[x] = {.w = is_positive ? w : -w, .missed = missed};
    recent.w = (7 * recent.w + w) >> 3;
    recent.missed = (7 * recent.missed + 2 * missed) >> 3;
  });
}

}  // namespace multitetra::shell

#include "common/codec/shell_decoder.hpp"

#include "common/codec/detail/corrections.hpp"
#include "common/codec/detail/range_coder.hpp"

namespace multitetra::shell {

namespace {

// Computes the steps from an edge's start to its vertex from the values at its ends.
class ExactCuts {
 public:
  ExactCuts(SampleRings& rings, const ShellHeader& header)
      : rings_(rings), isovalue_(header.isovalue), steps_(header.steps()) {}

  [[nodiscard]] int32_t operator()(int x, int y, int z, int direction) const {
    const EdgeDirection d = kEdgeDirection[direction];
    const double from = static_cast<double>(rings_.values(y, z)[x]);
    const double to = static_cast<double>(rings_.values(y + d.y, z + d.z)[x + d.x]);
    return begins_at_other_end(d) ? steps_ - exact_cut(to, from, isovalue_, steps_)
                                  : exact_cut(from, to, isovalue_, steps_);
  }

 private:
  SampleRings& rings_;
  double isovalue_;
  int32_t steps_;
};

// Computes the same from the levels of the ends.
class LevelCuts {
 public:
  LevelCuts(SampleRings& rings, const LevelScale& scale) : rings_(rings), scale_(scale) {}

  [[nodiscard]] int32_t operator()(int x, int y, int z, int direction) const {
    const EdgeDirection d = kEdgeDirection[direction];
    return scale_.cut(rings_.levels(y, z)[x], rings_.levels(y + d.y, z + d.z)[x + d.x]);
  }

 private:
  SampleRings& rings_;
  const LevelScale& scale_;
};

// Computes the same from the levels and a decoded correction.
class CorrectedCuts {
 public:
  CorrectedCuts(RangeDecoder& coder, CorrectionModel& model, SampleRings& rings,
                const LevelScale& scale, int32_t steps)
      : coder_(coder), model_(model), rings_(rings), scale_(scale), steps_(steps) {}

  [[nodiscard]] int32_t operator()(int x, int y, int z, int direction) const {
    const EdgeDirection d = kEdgeDirection[direction];
    return code_cut(coder_, model_, scale_, steps_, rings_.levels(y, z)[x],
                    rings_.levels(y + d.y, z + d.z)[x + d.x], 0);
  }

 private:
  RangeDecoder& coder_;
  CorrectionModel& model_;
  SampleRings& rings_;
  const LevelScale& scale_;
  int32_t steps_;
};

// Stores the values of exact samples, given their magnitudes.
class ExactSamples {
 public:
  ExactSamples(SampleRings& rings, const ShellHeader& header)
      : rings_(rings), below_(floor_of(header.isovalue)), layer_value_(header.layer_value) {}

  void keep(int x, int y, int z, bool is_positive, int32_t magnitude) const {
    const int32_t value = is_positive ? below_ + 1 + magnitude : below_ - magnitude;
    rings_.values(y, z)[x] = static_cast<float>(value);
  }
  void keep_layer(int x, int y, int z) const { rings_.values(y, z)[x] = layer_value_; }

 private:
  static int32_t floor_of(double v) {
    const auto towards_zero = static_cast<int32_t>(v);
    return static_cast<double>(towards_zero) > v ? towards_zero - 1 : towards_zero;
  }

  SampleRings& rings_;
  int32_t below_;
  float layer_value_;
};

class LevelSamples {
 public:
  LevelSamples(SampleRings& rings, const ShellHeader& header)
      : rings_(rings), layer_level_(header.layer_level) {}

  void keep(int x, int y, int z, bool, int32_t level) const { rings_.levels(y, z)[x] = level; }
  void keep_layer(int x, int y, int z) const { rings_.levels(y, z)[x] = layer_level_; }

 private:
  SampleRings& rings_;
  int32_t layer_level_;
};

}  // namespace

// Decodes slice by slice: samples, vertices, cells.
template <typename Magnitudes, typename Kept, typename Cuts>
bool ShellDecoder::decode_slices(RangeDecoder& coder, const ShellHeader& header,
                                 const Magnitudes& magnitudes, const Kept& kept, const Cuts& cuts,
                                 ShellVertex* vertices, ShellTriangle* triangles) {
  RunningMeans recent = Magnitudes::start();
  const DataBox data(header);
  for (int z = 0; z < header.samples[2]; ++z) {
    edges_.find(z);
    rings_.begin_slice(z, header.samples[1]);
    for (int y = 0; y < header.samples[1]; ++y) {
      const RowBits active = edges_.active(y, z);
      if (!active.any()) continue;
      const RowBits coded = active & data.row(y, z);
      code_row_of_samples(
          coder, model_.values, magnitudes, signs_, coded, y, z, rings_, recent, [] { return 0; },
          [&](int x, int32_t magnitude) { kept.keep(x, y, z, signs_.at(x, y, z), magnitude); });
      for_each_sample(active & ~coded, [&](int x) { kept.keep_layer(x, y, z); });
    }
    const auto cut_in = [&cuts](int slice) {
      return [&cuts, slice](int x, int y, int direction) { return cuts(x, y, slice, direction); };
    };
    if (z > 0 && !marching_.add_vertices(edges_, z - 1, kDirectionsInSlice, kEdgeDirections,
                                         vertices, cut_in(z - 1))) {
      return false;
    }
    if (!marching_.add_vertices(edges_, z, 0, kDirectionsInSlice, vertices, cut_in(z))) {
      return false;
    }
    if (z > 0 && !marching_.add_cells(z - 1, vertices, triangles)) return false;
    if (coder.is_overrun()) return false;
  }
  return true;
}

ShellStatus ShellDecoder::decode(const uint8_t* bytes, size_t size, ShellVertex* vertices,
                                 ShellTriangle* triangles) {
  ShellHeader header;
  const ShellStatus status = read_shell_header(bytes, size, header);
  if (status != ShellStatus::kOk) return status;
  RangeDecoder coder(bytes + header.range_begin, size - header.range_begin,
                     bytes + header.raw_begin, header.range_begin - header.raw_begin);
  model_.begin(header.values);
  const int low[3] = {header.layer(0, false), header.layer(1, false), header.layer(2, false)};
  const auto decode_field = [&](SignModel& model, BitField& field, bool of_layers) {
    field.begin(header.data_samples(0), header.data_samples(1), header.data_samples(2));
    code_signs(coder, model, blocks_, field);
    if (header.layers == 0) return;
    field.enclose(low, header.samples, of_layers);
    field.finish();
  };
  if (header.has_void) decode_field(model_.presence, present_, true);
  decode_field(model_.signs, signs_, header.layer_is_positive);
  if (coder.is_overrun()) return ShellStatus::kBadContents;

  const BitField* const present = header.has_void ? &present_ : nullptr;
  edges_.begin(signs_, present, header.origin);
  rings_.begin();
  marching_.begin(signs_, present, header);
  bool is_whole = false;
  if (header.values == ShellValues::kExact) {
    is_whole = decode_slices(coder, header, ExactMagnitudes(), ExactSamples(rings_, header),
                             ExactCuts(rings_, header), vertices, triangles);
  } else {
    scale_.begin(header);
    const LevelMagnitudes magnitudes(scale_);
    const LevelSamples kept(rings_, header);
    is_whole = header.values == ShellValues::kQuantized
                   ? decode_slices(coder, header, magnitudes, kept, LevelCuts(rings_, scale_),
                                   vertices, triangles)
                   : decode_slices(
                         coder, header, magnitudes, kept,
                         CorrectedCuts(coder, model_.corrections, rings_, scale_, header.steps()),
                         vertices, triangles);
  }
  const bool is_as_promised = is_whole && coder.is_used_up() &&
                              marching_.vertices() == header.vertices &&
                              marching_.triangles() == header.triangles;
  return is_as_promised ? ShellStatus::kOk : ShellStatus::kBadContents;
}

}  // namespace multitetra::shell

#include "common/codec/shell_encoder.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "common/codec/detail/corrections.hpp"
#include "common/codec/detail/crossed_edges.hpp"
#include "common/codec/detail/header_writer.hpp"
#include "common/codec/detail/level_of_distance.hpp"
#include "common/codec/detail/level_scale.hpp"
#include "common/codec/detail/magnitude_coder.hpp"
#include "common/codec/detail/marching.hpp"
#include "common/codec/detail/range_encoder.hpp"
#include "common/codec/detail/row_bits.hpp"
#include "common/codec/detail/shell_model.hpp"
#include "common/codec/detail/sign_coder.hpp"

namespace multitetra::shell {

namespace {

// Returns t, of the type of integer or float v, such that v > isovalue if and only if v > t.
template <typename Sample>
[[nodiscard]] auto threshold_for(double isovalue) {
  if constexpr (std::is_floating_point_v<Sample>) {
    const auto nearest =
        static_cast<float>(std::clamp(isovalue, -double{std::numeric_limits<float>::max()},
                                      double{std::numeric_limits<float>::max()}));
    return static_cast<double>(nearest) > isovalue
               ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
               : nearest;
  } else {
    using Limits = std::numeric_limits<Sample>;
    // One below the minimum if all values are above the isovalue.
    return static_cast<std::int32_t>(
        std::clamp(std::floor(isovalue), double{Limits::min()} - 1, double{Limits::max()}));
  }
}

// Sets bit i to holds(first[i]), eight samples at a time.
template <typename Sample, typename Holds>
[[nodiscard]] RowBits bits_of_row(const Sample* first, int count, const Holds& holds) {
  std::uint64_t words[2] = {};
  int x = 0;
  for (; x + 8 <= count; x += 8) {
    std::uint8_t bytes[8];
    for (int i = 0; i < 8; ++i) bytes[i] = holds(first[x + i]) ? 1 : 0;
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, sizeof(word));
    words[x >> 6] |= (word * 0x0102040810204080U) >> 56 << (x & 63);
  }
  for (; x < count; ++x) words[x >> 6] |= std::uint64_t{holds(first[x]) ? 1U : 0U} << (x & 63);
  return of_previous({words[0], words[1]});
}

// Sets the bits of all samples; returns whether any is clear.
template <typename Sample, typename Holds>
bool fill_field(const SampleBlock<Sample>& block, const std::array<std::int32_t, 3>& size,
                const Holds& holds, BitField& field) {
  field.begin(size[0], size[1], size[2]);
  bool all = true;
  for (int z = 0; z < size[2]; ++z) {
    for (int y = 0; y < size[1]; ++y) {
      const RowBits bits =
          bits_of_row(block.first + block.row * y + block.slice * z, size[0], holds);
      field.row(y, z) = bits;
      all = all && bits == field.inside();
    }
  }
  return !all;
}

// Gives void samples the sign of the previous sample in x, or else in y, or else in z, which is
// cheapest to code.
void continue_into_void(const BitField& present, BitField& signs) {
  for (int z = 0; z < signs.size(2); ++z) {
    for (int y = 0; y < signs.size(1); ++y) {
      const RowBits holes = signs.inside() & ~present.row(y, z);
      for_each_sample(holes, [&](int x) {
        const bool before = x > 0   ? signs.at(x - 1, y, z)
                            : y > 0 ? signs.at(x, y - 1, z)
                                    : z > 0 && signs.at(x, y, z - 1);
        if (before) signs.row(y, z) |= samples_from_to(x, x + 1);
      });
    }
  }
}

}  // namespace

double displacement_bound(int levels_per_octave) {
  return 0.5 - 1 / (1 + std::exp2(1.0 / levels_per_octave));
}

class ShellEncoder::Work {
 public:
  void start(const ShellHeader& header) { header_ = header; }
  template <typename Sample>
  Result<std::vector<std::uint8_t>> encode(const SampleBlock<Sample>& block, const ShellBox& box,
                                           const ShellOptions& options);

 private:
  template <typename Sample>
  void find_signs(const SampleBlock<Sample>& block, const ShellBox& box, double isovalue);
  void count_surface();
  template <typename Sample, typename MagnitudeOf>
  bool append_magnitudes(const SampleBlock<Sample>& block, const MagnitudeOf& magnitude_of);
  template <typename Sample>
  Result<void> find_exact_magnitudes(const SampleBlock<Sample>& block, const ShellOptions& options);
  template <typename Sample>
  Result<void> find_levels(const SampleBlock<Sample>& block, const ShellOptions& options);
  Result<void> number_levels(std::int32_t layer_level);
  [[nodiscard]] std::int32_t unit_exponent() const;
  template <typename Sample, typename Magnitudes>
  void code_samples(const SampleBlock<Sample>& block, const ShellOptions& options,
                    const Magnitudes& magnitudes, RangeEncoder& coder);
  template <typename Sample>
  void code_corrections(const SampleBlock<Sample>& block, const ShellOptions& options, int z,
                        int first, int end, RangeEncoder& coder);

  // Returns a sample of the data, given coordinates in the box.
  template <typename Sample>
  [[nodiscard]] double value_at(const SampleBlock<Sample>& block, int x, int y, int z) const {
    return static_cast<double>(
        block.first[(x - header_.layer(0, false)) + block.row * (y - header_.layer(1, false)) +
                    block.slice * (z - header_.layer(2, false))]);
  }

  [[nodiscard]] const BitField* present() const { return header_.has_void ? &present_ : nullptr; }

  ShellHeader header_;
  SignBlocks blocks_;
  BitField unlayered_signs_;  // Before layers are added around the data.
  BitField unlayered_present_;
  BitField signs_;
  BitField present_;
  ShellModel model_;
  CrossedEdges edges_;
  SampleRings rings_;
  LevelScale scale_;
  Marching marching_;
  std::vector<RowBits> coded_;  // The coded samples, row by row.
  // The coded samples in order: magnitudes, or levels with kZeroDistance for v = c.
  std::vector<std::int32_t> magnitudes_;
  std::vector<std::uint32_t> histogram_;
};

template <typename Sample>
void ShellEncoder::Work::find_signs(const SampleBlock<Sample>& block, const ShellBox& box,
                                    double isovalue) {
  const auto threshold = threshold_for<Sample>(isovalue);
  const bool has_layers = box.layers != 0;
  BitField& signs = has_layers ? unlayered_signs_ : signs_;
  fill_field(
      block, box.data_samples, [threshold](Sample v) { return v > threshold; }, signs);
  header_.has_void = false;
  if constexpr (std::is_floating_point_v<Sample>) {
    BitField& present = has_layers ? unlayered_present_ : present_;
    header_.has_void = fill_field(
        block, box.data_samples, [](Sample v) { return v == v; }, present);
    if (header_.has_void) {
      continue_into_void(present, signs);
      present.finish();
    }
  }
  signs.finish();
  if (!has_layers) return;
  const int low[3] = {header_.layer(0, false), header_.layer(1, false), header_.layer(2, false)};
  const auto enclose = [&](const BitField& field, bool around, BitField& enclosed) {
    enclosed = field;
    enclosed.enclose(low, header_.samples, around);
    enclosed.finish();
  };
  enclose(unlayered_signs_, header_.layer_is_positive, signs_);
  if (header_.has_void) enclose(unlayered_present_, true, present_);
}

// Counts vertices and triangles, and determines the coded samples.
void ShellEncoder::Work::count_surface() {
  const DataBox data(header_);
  const int ny = header_.samples[1];
  const int nz = header_.samples[2];
  coded_.clear();
  header_.vertices = max_vertices(header_);
  header_.triangles = max_triangles(header_);
  edges_.begin(signs_, present(), header_.origin);
  marching_.begin(signs_, present(), header_);
  // With void samples, counts depend on more than signs, so the cells are marched.
  std::vector<ShellVertex> vertices(header_.has_void ? header_.vertices : 0);
  std::vector<ShellTriangle> found(header_.has_void ? header_.triangles : 0);
  std::uint32_t crossed = 0;
  std::uint32_t triangles = 0;
  for (int z = 0; z < nz; ++z) {
    edges_.find(z);
    for (int y = 0; y < ny; ++y) {
      const RowBits active = edges_.active(y, z);
      coded_.push_back(active & data.row(y, z));
      if (!edges_.any(y, z)) continue;
      for (int d = 0; d < kEdgeDirections; ++d) {
        crossed += static_cast<std::uint32_t>(count(edges_.crossed(d, y, z)));
      }
    }
    if (!header_.has_void) {
      if (z > 0) triangles += marching_.count_triangles(z - 1);
      continue;
    }
    const auto anywhere = [](int, int, int) { return 1; };
    bool has_room = true;
    if (z > 0) {
      has_room = marching_.add_vertices(edges_, z - 1, kDirectionsInSlice, kEdgeDirections,
                                        vertices.data(), anywhere);
    }
    has_room = has_room &&
               marching_.add_vertices(edges_, z, 0, kDirectionsInSlice, vertices.data(), anywhere);
    if (z > 0) has_room = has_room && marching_.add_cells(z - 1, vertices.data(), found.data());
    assert(has_room);  // The arrays have the maximum size.
    if (!has_room) break;
  }
  header_.vertices = header_.has_void ? marching_.vertices() : crossed;
  header_.triangles = header_.has_void ? marching_.triangles() : triangles;
}

// The level of a sample at the isovalue.
constexpr std::int32_t kZeroDistance = std::numeric_limits<std::int32_t>::min();

// Appends magnitude_of(sample) for all coded samples; returns false if one has none.
template <typename Sample, typename MagnitudeOf>
bool ShellEncoder::Work::append_magnitudes(const SampleBlock<Sample>& block,
                                           const MagnitudeOf& magnitude_of) {
  magnitudes_.clear();
  bool have_all = true;
  std::size_t row = 0;
  for (int z = 0; z < header_.samples[2]; ++z) {
    for (int y = 0; y < header_.samples[1]; ++y) {
      const RowBits coded = coded_[row++];
      if (!coded.any()) continue;
      const Sample* const samples = block.first + block.row * (y - header_.layer(1, false)) +
                                    block.slice * (z - header_.layer(2, false)) -
                                    header_.layer(0, false);
      for_each_sample(coded, [&](int x) {
        const std::optional<std::int32_t> magnitude = magnitude_of(samples[x]);
        have_all = have_all && magnitude;
        if (have_all) magnitudes_.push_back(*magnitude);
      });
    }
  }
  return have_all;
}

template <typename Sample>
Result<void> ShellEncoder::Work::find_exact_magnitudes(const SampleBlock<Sample>& block,
                                                       const ShellOptions& options) {
  const auto below = static_cast<std::int32_t>(std::floor(options.isovalue));
  const auto magnitude_of = [below](Sample sample) -> std::optional<std::int32_t> {
    if constexpr (std::is_floating_point_v<Sample>) {
      const bool is_integer =
          std::abs(sample) <= static_cast<float>(kMaxExactValue) && std::floor(sample) == sample;
      if (!is_integer) return std::nullopt;
    }
    const std::int32_t above = static_cast<std::int32_t>(sample) - below;
    return above > 0 ? above - 1 : -above;
  };
  if (append_magnitudes(block, magnitude_of)) return {};
  return not_encodable("An exact sample shell can only contain integers of at most 2^24");
}

template <typename Sample>
Result<void> ShellEncoder::Work::find_levels(const SampleBlock<Sample>& block,
                                             const ShellOptions& options) {
  const auto level_at = [&](double distance) {
    return distance > 0 ? level_of_distance(distance, header_.levels_per_octave) : kZeroDistance;
  };
  const auto level_of = [&](Sample sample) -> std::optional<std::int32_t> {
    const double distance = std::abs(static_cast<double>(sample) - options.isovalue);
    if (!(distance < std::numeric_limits<double>::infinity())) return std::nullopt;
    return level_at(distance);
  };
  if (!append_magnitudes(block, level_of)) {
    return not_encodable("A sample next to the surface is infinite");
  }
  const double layer = static_cast<double>(header_.layer_value);
  return number_levels(header_.layers != 0 ? level_at(std::abs(layer - options.isovalue))
                                           : kZeroDistance);
}

// Counts the levels from the least one that occurs; 0 is kZeroDistance.
Result<void> ShellEncoder::Work::number_levels(std::int32_t layer_level) {
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  std::int32_t most = kZeroDistance;
  const auto include = [&](std::int32_t level) {
    if (level != kZeroDistance) least = std::min(least, level);
    most = std::max(most, level);
  };
  for (const std::int32_t level : magnitudes_) include(level);
  include(layer_level);
  if (most == kZeroDistance) least = most = 0;  // All are at the isovalue.
  if (std::int64_t{most} - least + 2 > kMaxLevels) {
    return not_encodable("The magnitudes of the samples next to the surface differ too much");
  }
  header_.first_level = least;
  header_.levels = most - least + 2;
  const auto number = [least](std::int32_t level) {
    return level == kZeroDistance ? 0 : level - least + 1;
  };
  histogram_.assign(static_cast<std::size_t>(header_.levels), 0);
  for (std::int32_t& level : magnitudes_) {
    level = number(level);
    ++histogram_[static_cast<std::size_t>(level)];
  }
  header_.layer_level = number(layer_level);
  header_.unit_exponent = unit_exponent();
  return {};
}

// Returns the exponent that maps the median's octave to 2^10 units.
std::int32_t ShellEncoder::Work::unit_exponent() const {
  std::size_t median = 0;
  for (std::size_t seen = histogram_[0]; 2 * seen < magnitudes_.size();)
    seen += histogram_[++median];
  const std::int32_t median_level =
      header_.first_level + std::max<std::int32_t>(static_cast<std::int32_t>(median), 1) - 1;
  return (median_level >> floor_log2(static_cast<std::uint32_t>(header_.levels_per_octave))) - 10;
}

template <typename Sample>
void ShellEncoder::Work::code_corrections(const SampleBlock<Sample>& block,
                                          const ShellOptions& options, int z, int first, int end,
                                          RangeEncoder& coder) {
  const DataBox data(header_);
  const auto value = [&](int x, int y, int slice) {
    const bool is_data =
        header_.layers == 0 || (data.row(y, slice) & samples_from_to(x, x + 1)).any();
    return is_data ? value_at(block, x, y, slice) : static_cast<double>(header_.layer_value);
  };
  for (int y = 0; y < header_.samples[1]; ++y) {
    if (!edges_.any(y, z)) continue;
    for (int direction = first; direction < end; ++direction) {
      const EdgeDirection d = kEdgeDirection[direction];
      const RowBits& crossed = edges_.crossed(direction, y, z);
      if (!crossed.any()) continue;
      const std::int32_t* const from = rings_.levels(y, z);
      const std::int32_t* const to = rings_.levels(y + d.y, z + d.z);
      for_each_sample(crossed, [&](int x) {
        const double at_from = value(x, y, z);
        const double at_to = value(x + d.x, y + d.y, z + d.z);
        const std::int32_t steps = header_.steps();
        const std::int32_t cut = begins_at_other_end(d)
                                     ? steps - exact_cut(at_to, at_from, options.isovalue, steps)
                                     : exact_cut(at_from, at_to, options.isovalue, steps);
        code_cut(coder, model_.corrections, scale_, steps, from[x], to[x + d.x], cut);
      });
    }
  }
}

template <typename Sample, typename Magnitudes>
void ShellEncoder::Work::code_samples(const SampleBlock<Sample>& block, const ShellOptions& options,
                                      const Magnitudes& magnitudes, RangeEncoder& coder) {
  const bool has_corrections = options.values == ShellValues::kLatticeExact;
  const int ny = header_.samples[1];
  const DataBox data(header_);
  RunningMeans recent = Magnitudes::start();
  const std::int32_t* next = magnitudes_.data();
  rings_.begin();
  if (has_corrections) edges_.begin(signs_, present(), header_.origin);
  for (int z = 0; z < header_.samples[2]; ++z) {
    rings_.begin_slice(z, ny);
    if (has_corrections) edges_.find(z);
    for (int y = 0; y < ny; ++y) {
      const RowBits coded = coded_[static_cast<std::size_t>(ny) * static_cast<std::size_t>(z) +
                                   static_cast<std::size_t>(y)];
      std::int32_t* const levels = rings_.levels(y, z);
      code_row_of_samples(
          coder, model_.values, magnitudes, signs_, coded, y, z, rings_, recent,
          [&next] { return *next++; },
          [levels](int x, std::int32_t magnitude) { levels[x] = magnitude; });
      if (!has_corrections) continue;
      for_each_sample(edges_.active(y, z) & ~coded,
                      [&](int x) { levels[x] = header_.layer_level; });
    }
    if (!has_corrections) continue;
    if (z > 0) {
      code_corrections(block, options, z - 1, kDirectionsInSlice, kEdgeDirections, coder);
    }
    code_corrections(block, options, z, 0, kDirectionsInSlice, coder);
  }
}

template <typename Sample>
Result<std::vector<std::uint8_t>> ShellEncoder::Work::encode(const SampleBlock<Sample>& block,
                                                             const ShellBox& box,
                                                             const ShellOptions& options) {
  find_signs(block, box, options.isovalue);
  count_surface();
  const bool is_exact = options.values == ShellValues::kExact;
  if (Result<void> found =
          is_exact ? find_exact_magnitudes(block, options) : find_levels(block, options);
      !found) {
    return tl::unexpected(found.error());
  }
  model_.begin(options.values);
  RangeEncoder coder;
  const bool has_layers = header_.layers != 0;
  if (header_.has_void) {
    code_signs(coder, model_.presence, blocks_, has_layers ? unlayered_present_ : present_);
  }
  code_signs(coder, model_.signs, blocks_, has_layers ? unlayered_signs_ : signs_);
  if (is_exact) {
    code_samples(block, options, ExactMagnitudes(), coder);
  } else {
    scale_.begin(header_);
    code_samples(block, options, LevelMagnitudes(scale_), coder);
  }
  coder.finish();
  std::vector<std::uint8_t> bytes = written_header(header_, coder.raw().size());
  bytes.insert(bytes.end(), coder.raw().begin(), coder.raw().end());
  bytes.insert(bytes.end(), coder.bytes().begin(), coder.bytes().end());
  return bytes;
}

ShellEncoder::ShellEncoder() : work_(std::make_unique<Work>()) {}
ShellEncoder::~ShellEncoder() = default;
ShellEncoder::ShellEncoder(ShellEncoder&&) noexcept = default;
ShellEncoder& ShellEncoder::operator=(ShellEncoder&&) noexcept = default;

Result<std::vector<std::uint8_t>> ShellEncoder::encode(const ShellBox& box,
                                                       const ShellOptions& options) {
  Result<ShellHeader> header = header_for(box, options);
  if (!header) return tl::unexpected(header.error());
  work_->start(*header);
  return std::visit([&](const auto& block) { return work_->encode(block, box, options); },
                    box.samples);
}

}  // namespace multitetra::shell

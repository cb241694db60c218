// Smooths the border between labels after its first magnitudes (see label_borders.hpp), which
// follow the steps of the samples.
//
// The field is a label's magnitude in its samples and minus the magnitude in those of others. Along
// the border, the curvature of a smooth surface varies little; so each pass reduces the second
// differences of the second differences of the field (as thin-plate smoothing does), along the
// directions in which both neighbors are border samples. Signs stay, so that every sample keeps its
// label, as in Lempitsky, "Surface extraction from binary volumes with higher-order smoothness"
// (CVPR 2010).
//
// The first magnitudes shrink convex parts, as smoothing an indicator does, in proportion to the
// second differences of the field; the first pass takes that back. Around thin parts, smoothing
// says nothing: there, the first pass puts the border at the middle of the edges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/volume/labels/border_samples.hpp"

namespace multitetra {

class BorderSmoothing {
 public:
  using ReadSamples = std::function<void(std::int32_t z, std::span<BorderSample> into)>;
  using StoreSamples = std::function<void(std::int32_t z, std::span<const BorderSample> samples)>;

  // Keeps references to the functions.
  BorderSmoothing(const LabelDims& dims, const ReadLabels& read_labels,
                  const ReadSamples& read_samples);

  // Goes once through all slices; calls `store` with each and its new magnitudes.
  void smooth(const StoreSamples& store, bool is_first);

 private:
  struct Slice {
    std::vector<std::int32_t> labels;
    std::vector<BorderSample> samples;
    std::vector<float> magnitudes;  // 0: no border sample.
    std::vector<float> curvatures;  // Second differences of the field.
  };
  // From the slice being loaded to the one below that being smoothed.
  static constexpr std::size_t kWindow = 4;

  Slice& slice(std::int32_t z) { return window_[static_cast<std::size_t>(z) % kWindow]; }
  void load(std::int32_t z);
  void find_curvatures(std::int32_t z);
  void write(std::int32_t z, bool is_first, std::span<BorderSample> into);
  // Whether the sample or one of its 26 neighbors is a thin part of its label.
  [[nodiscard]] bool touches_thin_part(const LabelDims& at);
  // Returns the mean second difference at a border sample of values whose signs depend on the
  // label.
  [[nodiscard]] float second_difference(const LabelDims& at, std::vector<float> Slice::*values);

  LabelDims dims_;
  const ReadLabels& read_labels_;
  const ReadSamples& read_samples_;
  std::array<Slice, kWindow> window_;
};

}  // namespace multitetra

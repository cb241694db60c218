#include "server/volume/labels/label_borders.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "server/volume/labels/border_smoothing.hpp"
#include "server/volume/labels/label_cell.hpp"
#include "server/volume/labels/label_smoothing.hpp"

namespace multitetra {
namespace {

// More rounds preserve more of parts one sample thick along a diagonal; more averaging gives
// smoother surfaces. A flat border moves by a step if magnitudes change by 0.375 of the field's
// range, so a gain of about that corrects it in one round.
constexpr int kSmoothings = 4;
constexpr int kRounds = 7;
constexpr std::int32_t kAveragings = 6;
static_assert(kLabelReach == 6 + kSmoothings * 2 + kRounds * (1 + kAveragings));
constexpr double kGain = 0.6 * kFieldSteps;
constexpr double kThickGain = 0.5 * kFieldSteps;

// A missing volume, and the number of samples that share it.
struct Shortfall {
  float volume = 0;
  float weight = 0;
};

struct BorderSlice {
  std::int32_t z = -1;
  std::vector<std::uint32_t> numbers;  // Per sample: number of the border sample from 1, or 0.
  // The following are indexed by border sample.
  std::vector<std::uint32_t> indices;  // Positions in the slice, increasing.
  std::vector<std::int32_t> labels;
  std::vector<BorderSample> samples;
  // Indexed by number of averagings.
  std::array<std::vector<Shortfall>, kAveragings + 1> shortfalls;
};

}  // namespace

// A pass over all slices. The shortfalls of a slice are complete once the next one is loaded, and
// each averaging needs both neighbors, so each stage runs one slice behind the previous one.
class LabelBorders::Round {
 public:
  Round(const LabelBorders& borders, const ReadLabels& read)
      : borders_(borders),
        dims_(borders.dims_),
        read_(read),
        stored_(slice_samples(dims_)),
        stored_labels_(slice_samples(dims_)) {
    for (BorderSlice& slice : window_) slice.numbers.resize(slice_samples(dims_));
  }

  // Calls `corrected` with every slice that has border samples, and these with new magnitudes.
  void correct(double thick_gain,
               const std::function<void(std::int32_t, std::span<const BorderSample>)>& corrected) {
    for (std::int32_t z = 0; z <= dims_[2] + kAveragings; ++z) {
      load(z);
      add_cells(z - 1, [](std::int32_t, double) {});
      for (std::int32_t stage = 1; stage <= kAveragings; ++stage) average(z - 1 - stage, stage);
      BorderSlice* const done = find(z - 1 - kAveragings);
      if (done == nullptr || done->indices.empty()) continue;
      correct(*done, thick_gain);
      corrected(done->z, stored_);
    }
  }

  [[nodiscard]] std::map<std::int32_t, double> shortfalls() {
    std::map<std::int32_t, double> sums;
    for (std::int32_t z = 0; z < dims_[2]; ++z) {
      load(z);
      add_cells(z - 1, [&](std::int32_t label, double volume) { sums[label] += volume; });
    }
    return sums;
  }

 private:
  // From the slice being loaded to the one below the last averaged one.
  static constexpr std::size_t kWindow = kAveragings + 3;

  BorderSlice* find(std::int32_t z) {
    if (z < 0 || z >= dims_[2]) return nullptr;
    return &window_[static_cast<std::size_t>(z) % kWindow];
  }

  void load(std::int32_t z) {
    BorderSlice* const slice = find(z);
    if (slice == nullptr) return;
    for (const std::uint32_t place : slice->indices) slice->numbers[place] = 0;
    slice->z = z;
    slice->indices.clear();
    slice->labels.clear();
    slice->samples.clear();
    const std::uint32_t count = borders_.border_samples_[static_cast<std::size_t>(z)];
    if (count > 0) {
      borders_.get(z, stored_);
      read_(z, stored_labels_);
      for (std::size_t i = 0; i < stored_.size(); ++i) {
        if (stored_[i].magnitude == 0) continue;
        slice->indices.push_back(static_cast<std::uint32_t>(i));
        slice->labels.push_back(stored_labels_[i]);
        slice->samples.push_back(stored_[i]);
        slice->numbers[i] = static_cast<std::uint32_t>(slice->indices.size());
      }
    }
    slice->shortfalls[0].assign(count, {});
  }

  // Adds the shortfalls of the cells between slice z and the next one.
  template <typename Seen>
  void add_cells(std::int32_t z, const Seen& seen) {
    BorderSlice* const lower = find(z);
    BorderSlice* const upper = find(z + 1);
    if (lower == nullptr || upper == nullptr || upper->indices.empty()) return;
    const auto width = static_cast<std::size_t>(dims_[0]);
    for (const std::uint32_t place : lower->indices) {
      const std::size_t x = place % width;
      const std::size_t y = place / width;
      if (x + 1 == width || y + 1 == static_cast<std::size_t>(dims_[1])) continue;
      LabelCell cell;
      std::array<Shortfall*, 8> shares{};
      bool is_mixed = true;
      for (std::size_t corner = 0; corner < 8 && is_mixed; ++corner) {
        BorderSlice& slice = corner < 4 ? *lower : *upper;
        const std::uint32_t number =
            slice.numbers[place + (corner & 1) + ((corner & 2) != 0 ? width : 0)];
        is_mixed = number != 0;
        if (!is_mixed) break;
        cell.labels[corner] = slice.labels[number - 1];
        cell.magnitudes[corner] = slice.samples[number - 1].magnitude;
        shares[corner] = &slice.shortfalls[0][number - 1];
      }
      if (!is_mixed) continue;
      cell.even_corner =
          static_cast<unsigned>((x & 1) | (y & 1) << 1) | (static_cast<unsigned>(z) & 1U) << 2;
      add_cell(cell, shares, seen);
    }
  }

  template <typename Seen>
  static void add_cell(const LabelCell& cell, const std::array<Shortfall*, 8>& shares,
                       const Seen& seen) {
    for (std::size_t first = 0; first < 8; ++first) {
      const std::int32_t label = cell.labels[first];
      const auto begin = cell.labels.begin();
      if (std::find(begin, begin + static_cast<std::ptrdiff_t>(first), label) !=
          begin + static_cast<std::ptrdiff_t>(first)) {
        continue;
      }
      const auto count = static_cast<double>(std::count(begin, cell.labels.end(), label));
      if (count == 8) return;
      const double missing = count / 8 - part_of_cell(cell, label);
      seen(label, missing);
      for (std::size_t corner = first; corner < 8; ++corner) {
        if (cell.labels[corner] != label) continue;
        shares[corner]->volume += static_cast<float>(missing / count);
        shares[corner]->weight += static_cast<float>(1 / count);
      }
    }
  }

  // Averages over the neighbors of the same label, with the weights 1 2 1 along each axis.
  void average(std::int32_t z, std::int32_t stage) {
    BorderSlice* const slice = find(z);
    if (slice == nullptr) return;
    const auto from = static_cast<std::size_t>(stage - 1);
    std::vector<Shortfall>& into = slice->shortfalls[static_cast<std::size_t>(stage)];
    into.resize(slice->indices.size());
    const std::int32_t width = dims_[0];
    for (std::size_t i = 0; i < into.size(); ++i) {
      const auto x = static_cast<std::int32_t>(slice->indices[i]) % width;
      const auto y = static_cast<std::int32_t>(slice->indices[i]) / width;
      Shortfall sum;
      for (std::int32_t w = z - 1; w <= z + 1; ++w) {
        const BorderSlice* const other = find(w);
        if (other == nullptr || other->indices.empty()) continue;
        for (std::int32_t v = std::max(y - 1, 0); v <= std::min(y + 1, dims_[1] - 1); ++v) {
          for (std::int32_t u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
            const std::uint32_t number = other->numbers[static_cast<std::size_t>(u + width * v)];
            if (number == 0 || other->labels[number - 1] != slice->labels[i]) continue;
            const int steps = (w != z ? 1 : 0) + (u != x ? 1 : 0) + (v != y ? 1 : 0);
            const auto weight = static_cast<float>(8 >> steps);
            sum.volume += weight * other->shortfalls[from][number - 1].volume;
            sum.weight += weight * other->shortfalls[from][number - 1].weight;
          }
        }
      }
      into[i] = sum;
    }
  }

  // Writes the corrected samples to stored_.
  void correct(const BorderSlice& slice, double thick_gain) {
    std::fill(stored_.begin(), stored_.end(), BorderSample{});
    for (std::size_t i = 0; i < slice.indices.size(); ++i) {
      BorderSample sample = slice.samples[i];
      stored_[slice.indices[i]] = sample;
      if (slice.labels[i] == kBeyondMap) continue;
      const Shortfall& shortfall = slice.shortfalls[kAveragings][i];
      const double change = (sample.is_thick != 0 ? thick_gain : kGain) *
                            static_cast<double>(shortfall.volume) /
                            static_cast<double>(shortfall.weight);
      const double magnitude = std::floor(sample.magnitude + change + 0.5);
      sample.magnitude = static_cast<std::uint8_t>(
          static_cast<int>(std::clamp<double>(magnitude, kMinMagnitude, kMaxMagnitude)) & 0x7F);
      stored_[slice.indices[i]] = sample;
    }
  }

  const LabelBorders& borders_;
  const LabelDims& dims_;
  const ReadLabels& read_;
  std::array<BorderSlice, kWindow> window_;
  std::vector<BorderSample> stored_;
  std::vector<std::int32_t> stored_labels_;
};

LabelBorders::LabelBorders(const LabelDims& dims, const ReadLabels& read,
                           const std::filesystem::path& scratch_folder)
    : dims_(dims), scratch_(std::make_unique<ScratchFile>(scratch_folder)) {
  const std::uint64_t bytes = slice_samples(dims);
  const auto store = [&](std::int32_t z, std::span<const BorderSample> samples) {
    scratch_->write_at(static_cast<std::uint64_t>(z) * bytes, std::as_bytes(samples));
  };
  BorderSearch search(dims_, read);
  std::vector<BorderSample> first(bytes);
  for (std::int32_t z = 0; z < dims[2]; ++z) {
    border_samples_.push_back(search.next(first));
    if (border_samples_.back() > 0) store(z, first);
  }
  const BorderSmoothing::ReadSamples read_samples =
      [&](std::int32_t z, std::span<BorderSample> into) { get(z, into); };
  BorderSmoothing smoothing(dims, read, read_samples);
  for (int i = 0; i < kSmoothings; ++i) {
    smoothing.smooth(
        [&](std::int32_t z, std::span<const BorderSample> samples) {
          if (border_samples_[static_cast<std::size_t>(z)] > 0) store(z, samples);
        },
        i == 0);
  }
  Round round(*this, read);
  for (int i = 0; i < kRounds; ++i) round.correct(i == 0 ? kThickGain : 0, store);
  shortfalls_ = round.shortfalls();
}

void LabelBorders::get(std::int32_t z, std::span<BorderSample> into) const {
  if (border_samples_[static_cast<std::size_t>(z)] == 0) {
    std::fill(into.begin(), into.end(), BorderSample{});
    return;
  }
  scratch_->get(static_cast<std::uint64_t>(z) * into.size(), std::as_writable_bytes(into));
}

}  // namespace multitetra

// Makes the error spectrum of a volume that passes by once, slice after slice.
//
//   SpectrumBuilder builder(info, bins, sink, for_each);
//   for (each slab) builder.add(slab, slices);
//   builder.finish();
//
// The volume is cut along x and y into columns. A column computes the curves of spacings 1, 2 and 4
// for itself, with a seam of six steps around it that is computed twice, and keeps only those of
// the cube centres of spacing 4: one per cell of 8 x 8 x 8. From these, and from every eighth
// sample, the coarser levels follow for all columns together. Memory is in proportion to a slab and
// to the cells, not to the volume's extent along z.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/dataset_info.hpp"
#include "server/core/for_each.hpp"
#include "server/core/isovalue_bins.hpp"
#include "server/core/volume.hpp"

namespace multitetra {

class SpectrumBuilder {
 public:
  // Takes the bytes of one brick of SpectrumLayout(info). Each brick at most once, in any order but
  // always the same; those that are never taken are empty.
  using Sink = std::function<void(std::size_t brick, std::span<const std::byte> bytes)>;

  // Makes at least `least_columns` columns where there is enough to cut: as many as `for_each`
  // needs to keep its threads busy. The result is the same for any number.
  SpectrumBuilder(const DatasetInfo& info, IsovalueBins bins, Sink sink,
                  ForEach for_each = one_after_another, std::size_t least_columns = 1);
  ~SpectrumBuilder();
  SpectrumBuilder(const SpectrumBuilder&) = delete;
  SpectrumBuilder& operator=(const SpectrumBuilder&) = delete;

  // The next slices along z: dims x * y * slices samples of the dataset's type, x fastest.
  void add(const Samples& slab, std::int32_t slices);
  // After the last slice.
  void finish();

  // Every sample whose grid coordinates are multiples of kSpectrumSpacing, x fastest, in the
  // dataset's type. Complete after finish().
  [[nodiscard]] const Samples& coarse_samples() const;

 private:
  class Work;
  template <typename Real>
  class TypedWork;
  std::unique_ptr<Work> work_;
};

}  // namespace multitetra

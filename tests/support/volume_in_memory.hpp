// A volume in memory as the source of a preparation.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "server/volume/volume_source.hpp"

namespace multitetra {

class VolumeInMemory : public VolumeSource {
 public:
  explicit VolumeInMemory(Volume volume)
      : header_(header_of(volume)), samples_(std::move(volume.samples)) {}

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    assert(first_slice >= 0 && slices >= 1 && first_slice <= header_.dims[2] - slices);
    const std::size_t begin = static_cast<std::size_t>(first_slice) * header_.samples_per_slice();
    const std::size_t end = begin + static_cast<std::size_t>(slices) * header_.samples_per_slice();
    std::visit(
        [&](const auto& all) {
          using Values = std::decay_t<decltype(all)>;
          if (!std::holds_alternative<Values>(into)) into = Values();
          std::get<Values>(into).assign(all.begin() + static_cast<std::ptrdiff_t>(begin),
                                        all.begin() + static_cast<std::ptrdiff_t>(end));
        },
        samples_);
  }

  [[nodiscard]] Samples take_all() override { return std::move(samples_); }

 private:
  VolumeHeader header_;
  Samples samples_;
};

inline std::unique_ptr<VolumeSource> source_of(Volume volume) {
  return std::make_unique<VolumeInMemory>(std::move(volume));
}

}  // namespace multitetra

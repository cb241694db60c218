// The model of PreparedModel with the exact errors of all points: slow to compute, for comparison.
#pragma once

#include <memory>
#include <utility>

#include "server/core/errors/error_based_model.hpp"
#include "server/core/spectrum/error_spectrum.hpp"

namespace multitetra {

// Uses the spectrum for points of spacing kSpectrumSpacing or more and exact errors for the others.
// Conforms for the same reason as PreparedModel.
class SpectrumModel final : public Model {
 public:
  SpectrumModel(std::shared_ptr<const SaturatedErrors> exact,
                std::shared_ptr<const SpectrumErrors> spectrum, ModelOptions options)
      : exact_(std::move(exact)), spectrum_(std::move(spectrum)), options_(std::move(options)) {}

  [[nodiscard]] bool kept(const DividingPoint& point) const override {
    return options_.keeps(
        point, point.spacing() < kSpectrumSpacing ? exact_->bound(point) : spectrum_->bound(point));
  }

 private:
  std::shared_ptr<const SaturatedErrors> exact_;
  std::shared_ptr<const SpectrumErrors> spectrum_;
  ModelOptions options_;
};

}  // namespace multitetra

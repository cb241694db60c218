#include "server/dataset/detail/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/base/printable_line.hpp"
#include "server/dataset/detail/statistics_builder.hpp"

namespace multitetra {
namespace {

// Names are also parts of paths and URLs, and are printed.
Result<void> check_name(std::string_view name) {
  if (name.empty() || name.size() > 255) {
    return fail(ErrorCode::kInvalidArgument, "A dataset's name must have 1 to 255 bytes, not " +
                                                 std::to_string(name.size()) + ".");
  }
  if (name == "." || name == "..") {
    return fail(ErrorCode::kInvalidArgument,
                "A dataset must not have the name \"" + std::string(name) +
                    "\", which refers to another folder in paths and URLs; choose another name.");
  }
  for (std::string_view rest = name; !rest.empty();) {
    const std::size_t length = utf8_sequence(rest);
    if (length == 0 || rest[0] == '/' || is_control_character(rest)) {
      return fail(ErrorCode::kInvalidArgument,
                  "A dataset's name must be UTF-8 without '/', control characters and "
                  "bidirectional formatting characters; this name is not valid: \"" +
                      printable_line(name, 255) + "\".");
    }
    rest.remove_prefix(length);
  }
  return {};
}

constexpr double kMinSpacing = 1e-30;
constexpr double kMaxSpacing = 1e30;

Result<void> check_grid(const DatasetInfo& info) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (info.dims[axis] < 1 || info.dims[axis] > (1 << kMaxGridExponent) + 1) {
      return fail(ErrorCode::kInvalidArgument,
                  "A dataset must have 1 to " + std::to_string((1 << kMaxGridExponent) + 1) +
                      " samples a side, not " + std::to_string(info.dims[axis]) + ".");
    }
    // Errors are floats in world units, from one grid step to thousands of them.
    if (!(info.spacing[axis] >= kMinSpacing && info.spacing[axis] <= kMaxSpacing)) {
      std::ostringstream spacing;
      spacing << info.spacing[axis];
      return fail(
          ErrorCode::kInvalidArgument,
          "A dataset's spacing must be 1e-30 to 1e30 world units, not " + spacing.str() + ".");
    }
  }
  if (info.margin < 0 || info.margin > 1 << kMaxGridExponent) {
    return fail(ErrorCode::kInvalidArgument,
                "The margin must be 0 to " + std::to_string(1 << kMaxGridExponent) +
                    " grid steps, not " + std::to_string(info.margin) + ".");
  }
  const std::int32_t exponent = grid_exponent_for(info.dims, info.margin);
  if (exponent > kMaxGridExponent) {
    return fail(ErrorCode::kInvalidArgument,
                "The data with a margin of " + std::to_string(info.margin) +
                    " does not fit the largest grid of " + std::to_string(1 << kMaxGridExponent) +
                    " steps a side.");
  }
  if (info.grid_exponent != exponent) {
    return fail(ErrorCode::kInvalidArgument,
                "The grid exponent must be " + std::to_string(exponent) +
                    " for these dims and margin, not " + std::to_string(info.grid_exponent) + ".");
  }
  const double volume = info.index_to_world.determinant();
  const Vec3& origin = info.index_to_world.translation;
  const bool finite =
      std::all_of(origin.begin(), origin.end(), [](double x) { return std::isfinite(x); });
  if (!std::isfinite(volume) || volume == 0 || !finite) {
    return fail(ErrorCode::kInvalidArgument,
                "The map from samples to the world is not finite or does not span space.");
  }
  return {};
}

Result<void> check_values(const DatasetInfo& info) {
  if (info.outside && !(std::abs(*info.outside) <= std::numeric_limits<float>::max())) {
    return fail(
        ErrorCode::kInvalidArgument,
        "The value outside the data must be a number that fits a 32-bit float; omit it for void.");
  }
  if (!std::isfinite(info.min) || !std::isfinite(info.max) || info.min > info.max) {
    return fail(ErrorCode::kInvalidArgument,
                "The range of the samples must be two finite numbers in increasing order.");
  }
  std::uint64_t samples = 1;
  for (const std::int32_t side : info.dims) samples *= static_cast<std::uint64_t>(side);
  const auto& counts = info.histogram.counts;
  if (counts.empty() || counts.size() > kMaxHistogramBins || !std::isfinite(info.histogram.low) ||
      !std::isfinite(info.histogram.high) || info.histogram.low >= info.histogram.high) {
    return fail(ErrorCode::kInvalidArgument, "The histogram must have 1 to " +
                                                 std::to_string(kMaxHistogramBins) +
                                                 " bins and a range with low below high.");
  }
  std::uint64_t counted = info.void_samples;
  for (const std::uint64_t count : counts) {
    if (count > samples || counted > samples) break;
    counted += count;
  }
  if (counted != samples) {
    return fail(ErrorCode::kInvalidArgument,
                "The sum of the histogram's counts and the void samples differs from the number of "
                "samples.");
  }
  const auto& isovalues = info.suggested_isovalues;
  if (isovalues.size() > kMaxSuggestedIsovalues ||
      !std::all_of(isovalues.begin(), isovalues.end(), [](double x) { return std::isfinite(x); })) {
    return fail(ErrorCode::kInvalidArgument,
                "At most " + std::to_string(kMaxSuggestedIsovalues) +
                    " isovalues may be suggested, and they must be finite.");
  }
  return {};
}

}  // namespace

SampleStatistics statistics(const Volume& volume) {
  SampleStatisticsBuilder builder(volume.type());
  builder.add(volume.samples);
  if (builder.needs_second_pass()) {
    builder.add_second_pass(std::get<std::vector<float>>(volume.samples));
  }
  return builder.finish();
}

Result<void> check_info(const DatasetInfo& info) {
  for (const std::string& unit : {info.meaning.length_unit, info.meaning.value_unit,
                                  info.meaning.assumed, info.meaning.rounding, info.missing}) {
    if (is_unit_text(unit)) continue;
    return fail(ErrorCode::kInvalidArgument, "A unit must be UTF-8 of at most " +
                                                 std::to_string(kMaxUnitBytes) +
                                                 " bytes without control characters.");
  }
  if (auto checked = check_name(info.name); !checked) return checked;
  if (info.member) {
    if (auto checked = check_member(*info.member); !checked) return checked;
  }
  if (auto checked = check_grid(info); !checked) return checked;
  return check_values(info);
}

DatasetInfo describe(const VolumeHeader& header, const SampleStatistics& facts, std::string name,
                     std::optional<double> outside, std::int32_t margin) {
  DatasetInfo info = {.name = std::move(name),
                      .dims = header.dims,
                      .type = header.type,
                      .spacing = header.spacing,
                      .index_to_world = header.index_to_world,
                      .meaning = header.meaning,
                      .min = facts.min,
                      .max = facts.max,
                      .void_samples = facts.void_samples,
                      .outside = outside,
                      .margin = margin,
                      .grid_exponent = grid_exponent_for(header.dims, std::max(margin, 0)),
                      .histogram = facts.histogram,
                      .suggested_isovalues = facts.suggested_isovalues};
  if (const auto checked = check_info(info); !checked) {
    throw std::invalid_argument(checked.error().text);
  }
  return info;
}

DatasetInfo describe(const Volume& volume, std::string name, std::optional<double> outside,
                     std::int32_t margin) {
  return describe(header_of(volume), statistics(volume), std::move(name), outside, margin);
}

}  // namespace multitetra

#include "server/volume/detail/sample_conversion.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/number_text.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

bool is_floating(StoredType type) { return type == StoredType::kF32 || type == StoredType::kF64; }

bool is_wide(StoredType type) { return type > StoredType::kF32; }

struct Range {
  double low;
  double high;
};

// Returns the range of integers of this type with `bits` used bits. Requires at most 32 bits.
Range range_of(StoredType type, int bits) {
  const int all = static_cast<int>(8 * bytes_of(type));
  const int used = bits > 0 && bits < all ? bits : all;
  const bool is_signed =
      type == StoredType::kI8 || type == StoredType::kI16 || type == StoredType::kI32;
  if (!is_signed) return {0, std::ldexp(1, used) - 1};
  return {-std::ldexp(1, used - 1), std::ldexp(1, used - 1) - 1};
}

// Returns a sample type that holds these integers exactly, preferably the stored one; else f32,
// except for i16 (see SampleConversion).
SampleType type_for(StoredType stored, const Range& range) {
  const auto holds = [&](SampleType type) {
    const Range all = range_of(static_cast<StoredType>(type), 0);
    return range.low >= all.low && range.high <= all.high;
  };
  if (!is_wide(stored) && holds(static_cast<SampleType>(stored))) {
    return static_cast<SampleType>(stored);
  }
  for (const SampleType type :
       {SampleType::kU8, SampleType::kI8, SampleType::kI16, SampleType::kU16}) {
    if (holds(type)) return type;
  }
  return stored == StoredType::kI16 ? SampleType::kI16 : SampleType::kF32;
}

}  // namespace

void resize(Samples& samples, SampleType type, std::size_t count) {
  visit_type(type, [&]<typename Sample>(const Sample*) {
    if (!std::holds_alternative<std::vector<Sample>>(samples)) samples = std::vector<Sample>();
    std::get<std::vector<Sample>>(samples).resize(count);
  });
}

std::byte* bytes_of(Samples& samples) {
  return std::visit([](auto& values) { return reinterpret_cast<std::byte*>(values.data()); },
                    samples);
}

std::uint64_t make_infinite_void(std::span<float> samples) {
  std::uint64_t infinite = 0;
  for (float& sample : samples) {
    if (!std::isinf(sample)) continue;
    sample = std::numeric_limits<float>::quiet_NaN();
    ++infinite;
  }
  return infinite;
}

// ---- SampleConversion

namespace {

// Files state numbers that mean void with other digits than samples of 32 bits have.
double rounded_to_float(double number) {
  constexpr double kMax = std::numeric_limits<float>::max();
  if (std::abs(number) <= kMax) return static_cast<float>(number);
  // Infinite from half a step beyond.
  return std::abs(number) < 0x1.ffffffp127 ? std::copysign(kMax, number)
                                           : number * std::numeric_limits<double>::infinity();
}

}  // namespace

SampleConversion::SampleConversion(std::filesystem::path file, const ImageHeader& header,
                                   ComponentChoice choice)
    : file_(std::move(file)), header_(header), choice_(choice) {
  using Kind = ComponentChoice::Kind;
  if (header_.type == StoredType::kF32) {
    for (double& number : header_.missing) number = rounded_to_float(number);
    if (header_.valid_range) {
      for (double& end : *header_.valid_range) end = rounded_to_float(end);
    }
  }
  const std::int64_t components = header_.components;
  const std::string description = "each sample has " + std::to_string(components) + " components";
  if (components == 1) choice_ = {.kind = Kind::kOnlyOne};
  if (components > 1 && choice_.kind == Kind::kOnlyOne) {
    fail_reading(file_, description,
                 "Choose with --component: one from 0 to " + std::to_string(components - 1) +
                     ", magnitude, or luminance (of red, green and blue)");
  }
  if (choice_.kind == Kind::kIndex && choice_.index >= components) {
    fail_reading(file_, description, "Choose one from 0 to " + std::to_string(components - 1));
  }
  if (choice_.kind == Kind::kLuminance && components < 3) {
    fail_reading(file_, description, "Luminance requires red, green and blue");
  }
  const bool mixes = choice_.kind == Kind::kMagnitude || choice_.kind == Kind::kLuminance;
  const bool is_integer = !is_floating(header_.type) && bytes_of(header_.type) <= 4;
  const bool is_exact = header_.slope == 1 && header_.intercept == std::round(header_.intercept) &&
                        !mixes && !header_.has_void();
  type_ = SampleType::kF32;
  if (is_integer && is_exact) {
    // Only the header's promise about wide integers permits a narrower type.
    const Range stored = range_of(header_.type, header_.stored_bits);
    const Range range = {stored.low + header_.intercept, stored.high + header_.intercept};
    type_ = type_for(header_.type, range);
  }
  is_none_ = components == 1 && header_.slope == 1 && header_.intercept == 0 &&
             !header_.has_void() && !is_wide(header_.type);
}

template <typename Stored>
double SampleConversion::value_of(const std::byte* sample) const {
  const auto at = [&](std::int64_t component) {
    Stored number;
    std::memcpy(&number, sample + static_cast<std::size_t>(component) * sizeof(Stored),
                sizeof(Stored));
    return static_cast<double>(number);
  };
  switch (choice_.kind) {
    case ComponentChoice::Kind::kOnlyOne:
      return at(0);
    case ComponentChoice::Kind::kIndex:
      return at(choice_.index);
    case ComponentChoice::Kind::kLuminance:
      return 0.2126 * at(0) + 0.7152 * at(1) + 0.0722 * at(2);
    case ComponentChoice::Kind::kMagnitude:
      break;
  }
  double squares = 0;
  for (std::int64_t i = 0; i < header_.components; ++i) squares += at(i) * at(i);
  return std::sqrt(squares);
}

template <typename Stored>
void SampleConversion::convert_from(const std::byte* stored, std::size_t count, Samples& into,
                                    std::size_t first) {
  const std::size_t sample_bytes = sizeof(Stored) * static_cast<std::size_t>(header_.components);
  const bool is_whole =
      std::is_same_v<Stored, std::int64_t> || std::is_same_v<Stored, std::uint64_t>;
  const bool plain = choice_.kind <= ComponentChoice::Kind::kIndex && header_.slope == 1;
  std::visit(
      [&](auto& samples) {
        using Sample = typename std::decay_t<decltype(samples)>::value_type;
        for (std::size_t i = 0; i < count; ++i, stored += sample_bytes) {
          double value = value_of<Stored>(stored);
          const bool missing = header_.has_void() && header_.is_void(value);
          value = header_.slope * value + header_.intercept;
          if constexpr (std::is_same_v<Sample, float>) {
            samples[first + i] =
                missing ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(value);
            if (!std::isfinite(samples[first + i])) {
              if (missing || !std::isfinite(value)) continue;
              ++too_large_;
              least_too_large_ = std::min(least_too_large_, value);
              greatest_too_large_ = std::max(greatest_too_large_, value);
              continue;
            }
            long double exact = value;
            if (is_whole && plain) {  // A double has too few bits.
              Stored number;
              std::memcpy(&number,
                          stored + static_cast<std::size_t>(choice_.index) * sizeof(Stored),
                          sizeof(Stored));
              exact = static_cast<long double>(number) + header_.intercept;
              value = static_cast<double>(exact);
              samples[first + i] = static_cast<float>(exact);
            }
            note(value, static_cast<double>(
                            std::abs(exact - static_cast<long double>(samples[first + i]))));
          } else {
            constexpr double kMin = std::numeric_limits<Sample>::lowest();
            constexpr double kMax = std::numeric_limits<Sample>::max();
            saturated_ += value < kMin || value > kMax;
            value = std::clamp(value, kMin, kMax);
            samples[first + i] = static_cast<Sample>(value);
          }
        }
      },
      into);
}

void SampleConversion::convert(const std::byte* stored, std::size_t count, Samples& into,
                               std::size_t first) {
  assert(!is_none_ && into.index() == static_cast<std::size_t>(type_));
  with_number_type(header_.type,
                   [&]<typename Stored>() { convert_from<Stored>(stored, count, into, first); });
}

void SampleConversion::note(double value, double error) {
  least_ = std::min(least_, value);
  greatest_ = std::max(greatest_, value);
  largest_error_ = std::max(largest_error_, error);
  // Multiples of an irrational number, modulo 1: even over any rows and slices.
  const std::uint64_t order = ++converted_ * 0x9E3779B97F4A7C15U;
  if (order > last_order_) return;
  some_.push_back({.value = value, .error = error, .order = order});
  constexpr std::size_t kMost = std::size_t{1} << 14;
  if (some_.size() < kMost) return;
  last_order_ /= 2;
  std::erase_if(some_, [&](const ConvertedValue& one) { return one.order > last_order_; });
}

SampleConversion::Loss SampleConversion::loss_between_ends() const {
  std::vector<ConvertedValue> some = some_;
  std::erase_if(some, [&](const ConvertedValue& one) {
    return one.value == least_ || one.value == greatest_;
  });
  constexpr std::size_t kFew = 100;
  if (some.size() < kFew) return {};
  const auto [low, high] = std::ranges::minmax(some, {}, &ConvertedValue::value);
  const double range = high.value - low.value;
  // Doubles that differ by less are meant to be equal.
  if (range <= 0x1p-30 * std::max(std::abs(low.value), std::abs(high.value))) return {};
  return {.low = low.value,
          .range = range,
          .error = std::ranges::max(some, {}, &ConvertedValue::error).error,
          .error_text = "about ",
          .range_text = "their range without its ends"};
}

SampleConversion::Loss SampleConversion::loss() const {
  // Samples that are all equal have no surface that rounding could move.
  const Loss all = {.low = least_,
                    .range = greatest_ > least_ ? greatest_ - least_ : 0,
                    .error = largest_error_,
                    .error_text = "up to ",
                    .range_text = "their range"};
  const Loss inside = loss_between_ends();
  return inside.share() > 2 * all.share() ? inside : all;
}

void SampleConversion::require_small_loss() const {
  const std::string what = "its samples of type " + std::string(name(header_.type));
  if (too_large_ > 0 && least_ > greatest_) {
    fail_reading(file_, "all " + what + " are beyond 3.4e38, the range of f32", "Scale them down");
  }
  // A single value marks samples that are missing.
  if (too_large_ > 0 && least_too_large_ < greatest_too_large_) {
    fail_reading(
        file_, std::to_string(too_large_) + " of " + what + " are beyond 3.4e38, the range of f32",
        "Scale them down, or make them void with --allow-loss");
  }
  const Loss lost = loss();
  if (lost.share() <= 0.01) return;
  const std::string text = what + " change by " + lost.error_text + rounded_text(lost.error) +
                           " as f32, " + rounded_text(std::round(1000 * lost.share()) / 10) +
                           " % of " + lost.range_text;
  if (lost.range < std::numeric_limits<float>::min()) {
    fail_reading(file_, text, "Scale them up, or accept the loss with --allow-loss");
  }
  const double unit = std::pow(10, std::ceil(std::log10(lost.range)));
  const double middle = std::round((lost.low + lost.range / 2) / unit) * unit;
  fail_reading(file_, text,
               "Keep them as differences from a value within their range with --subtract " +
                   shortest_text(middle) + ", or accept the loss with --allow-loss");
}

std::string SampleConversion::rounding() const {
  const Loss lost = loss();
  if (lost.share() <= 1e-4) return {};
  return lost.error_text + rounded_text(lost.error) + ", " + rounded_text(100 * lost.share()) +
         " % of " + lost.range_text;
}

void SampleConversion::report(const Notice& notice) const {
  const bool is_scaled = header_.slope != 1 || header_.intercept != 0;
  const bool is_typed_anew = type_ != static_cast<SampleType>(header_.type);
  if (!notice || (!is_scaled && !is_typed_anew && saturated_ == 0)) return;
  std::string text = "'" + file_.string() + "': samples of type " + std::string(name(header_.type));
  if (is_scaled) {
    text += " times " + shortest_text(header_.slope) + " plus " + shortest_text(header_.intercept);
  }
  if (is_typed_anew) text += " become " + std::string(name(type_));
  if (type_ == SampleType::kF32) {
    const Loss lost = loss();
    text += largest_error_ == 0 ? ", exactly"
                                : ", with errors of at most " + rounded_text(largest_error_);
    if (lost.share() > 0) {
      text += " (" + rounded_text(100 * lost.share()) + " % of " + lost.range_text + ")";
    }
    if (too_large_ > 0) {
      text += ", but for " + std::to_string(too_large_) + " of " + rounded_text(least_too_large_);
      if (least_too_large_ < greatest_too_large_) {
        text += " to " + rounded_text(greatest_too_large_);
      }
    }
  }
  if (saturated_ > 0) {
    text += "; " + counted(saturated_, "sample") + " beyond that type clamped to its range";
  }
  notice(text + ".");
}

void report_infinite(const Notice& notice, const std::filesystem::path& file,
                     std::uint64_t infinite) {
  if (!notice || infinite == 0) return;
  notice("'" + file.string() + "': void replaces " + counted(infinite, "sample") + " " +
         kInfiniteNotice + ".");
}

}  // namespace multitetra

// Checks the fields of untrusted messages and converts their enumerators. Private to the files that
// parse and serialize messages.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/result.hpp"
#include "common/wire/messages.hpp"

namespace multitetra::wire {

// The limit of names of datasets and programs.
inline constexpr std::size_t kMaxNameBytes = 255;
inline constexpr std::uint64_t kMaxU32 = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint64_t kMaxU64 = std::numeric_limits<std::uint64_t>::max();

// The first enumerator of our enums, which is 1 on the wire, where 0 means "unspecified".
template <typename Enum>
constexpr Enum kFirst = Enum{0};
template <>
inline constexpr PayloadCodec kFirst<PayloadCodec> = PayloadCodec::kDracoLattice;
template <>
inline constexpr WorldSpace kFirst<WorldSpace> = WorldSpace::kLps;
template <>
inline constexpr GeometryBasis kFirst<GeometryBasis> = GeometryBasis::kStated;
template <>
inline constexpr StreamOutcome kFirst<StreamOutcome> = StreamOutcome::kComplete;

template <typename Wire, typename Ours>
Wire to_wire(Ours value) {
  return static_cast<Wire>(static_cast<int>(value) - static_cast<int>(kFirst<Ours>) + 1);
}

// Keeps the first fault of a message. Values are still converted after a fault, but discarded.
class FieldChecks {
 public:
  void fail(ErrorCode code, std::string text) {
    if (!first_) first_ = Error{code, std::move(text)};
  }
  void require(bool holds, std::string_view field, std::string_view rule) {
    if (!holds) fail(ErrorCode::kInvalidArgument, std::string(field) + " " + std::string(rule));
  }
  void integer(std::string_view field, std::uint64_t value, std::uint64_t low,
               std::uint64_t high = kMaxU64) {
    if (value >= low && value <= high) return;
    fail(ErrorCode::kInvalidArgument,
         std::string(field) + " is " + std::to_string(value) + "; it must be " +
             (high == kMaxU64
                  ? std::to_string(low) + " or greater."
                  : "from " + std::to_string(low) + " to " + std::to_string(high) + "."));
  }
  void finite(std::string_view field, double value) {
    require(std::isfinite(value), field, "is not a finite number; it must be one.");
  }
  void not_negative(std::string_view field, double value) {
    require(std::isfinite(value) && value >= 0, field,
            "is negative or not finite; it must be a finite number, 0 or greater.");
  }
  void exactly(std::string_view field, int size, int wanted) {
    if (size == wanted) return;
    fail(ErrorCode::kInvalidArgument, std::string(field) + " has " + std::to_string(size) +
                                          " numbers; it must have " + std::to_string(wanted) + ".");
  }
  void at_most(std::string_view field, std::size_t size, std::size_t limit, std::string_view what) {
    if (size <= limit) return;
    fail(ErrorCode::kLimitExceeded, std::string(field) + " has " + std::to_string(size) + " " +
                                        std::string(what) + "; at most " + std::to_string(limit) +
                                        " are allowed.");
  }
  void dataset_name(std::string_view field, std::string_view name) {
    const auto allowed = [](char c) {
      return c != '/' && c != 0x7F && (static_cast<unsigned char>(c) >= 0x20);
    };
    require(!name.empty() && name.size() <= kMaxNameBytes && name != "." && name != ".." &&
                std::all_of(name.begin(), name.end(), allowed),
            field,
            "must have 1 to 255 bytes, no '/', no control characters, and not be '.' or '..'.");
  }
  void unit(std::string_view field, std::string_view text) {
    require(is_unit_text(text), field,
            "must be UTF-8 of at most 64 bytes without control characters.");
  }
  // Requires that a value passed its own validation.
  template <typename Value>
  void valid(const Result<Value>& validated) {
    if (!validated) fail(validated.error().code, validated.error().text);
  }
  // Converts `number` to one of our enumerators up to `last`. 0 gives `unspecified`, and is
  // rejected if that is empty.
  template <typename Ours>
  Ours enumerator(std::string_view field, int number, Ours last, std::optional<Ours> unspecified) {
    if (number == 0 && unspecified) return *unspecified;
    const int greatest = static_cast<int>(last) - static_cast<int>(kFirst<Ours>) + 1;
    if (number >= 1 && number <= greatest) {
      return static_cast<Ours>(number - 1 + static_cast<int>(kFirst<Ours>));
    }
    fail(ErrorCode::kInvalidArgument, std::string(field) + " has the number " +
                                          std::to_string(number) + "; valid numbers are 1 to " +
                                          std::to_string(greatest) + ".");
    return last;
  }

  [[nodiscard]] const std::optional<Error>& first() const { return first_; }

 private:
  std::optional<Error> first_;
};

}  // namespace multitetra::wire

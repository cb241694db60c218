// How it is known what the numbers of a file mean: their scaling, their sign, and which of them
// stand for no value.
//
//   ImageHeader header{.type = type, .values = kNumbersAsStored};
//
// There is no default: a reader that does not say how it knows each of the three does not compile.
#pragma once

#include <cstdint>
#include <string_view>

namespace multitetra {

enum class Basis : std::uint8_t {
  kByFormat,  // The format leaves no choice, or defines what the lack of a statement means.
  kStated,    // The file says so.
  kAssumed,   // Files of this kind may say so; this one does not.
};

[[nodiscard]] constexpr std::string_view name(Basis basis) {
  return basis == Basis::kByFormat ? "by format" : basis == Basis::kStated ? "stated" : "assumed";
}

struct ValueBasis {
  constexpr ValueBasis(Basis of_scaling, Basis of_sign, Basis of_missing)
      : scaling(of_scaling), sign(of_sign), missing(of_missing) {}

  Basis scaling;  // Of slope and intercept.
  Basis sign;     // Of integers.
  Basis missing;  // Of numbers that mean void.

  friend bool operator==(const ValueBasis&, const ValueBasis&) = default;
};

// Of formats whose numbers have a type, and are the values.
inline constexpr ValueBasis kNumbersAsStored = {Basis::kByFormat, Basis::kStated, Basis::kByFormat};

}  // namespace multitetra

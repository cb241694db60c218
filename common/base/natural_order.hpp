// An order of names in which numbers count by value: "label2" before "label10".
#pragma once

#include <string_view>

namespace multitetra {

// Returns whether `a` comes before `b` in a strict total order: names that differ only in leading
// zeros differ.
[[nodiscard]] bool natural_order_less(std::string_view a, std::string_view b);

// The comparison for sorted containers of names.
struct NaturalOrder {
  using is_transparent = void;
  [[nodiscard]] bool operator()(std::string_view a, std::string_view b) const {
    return natural_order_less(a, b);
  }
};

}  // namespace multitetra

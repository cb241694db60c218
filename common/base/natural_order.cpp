#include "common/base/natural_order.hpp"

#include <cstddef>

#include "common/base/text.hpp"

namespace multitetra {
bool natural_order_less(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      while (i < a.size() && a[i] == '0') ++i;
      while (j < b.size() && b[j] == '0') ++j;
      const std::string_view x = a.substr(i, digits_at(a, i));
      const std::string_view y = b.substr(j, digits_at(b, j));
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      i += x.size();
      j += y.size();
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // They differ at most in leading zeros.
}

}  // namespace multitetra

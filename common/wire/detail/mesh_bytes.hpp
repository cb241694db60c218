// Helpers of the mesh file readers.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "common/base/text.hpp"
#include "common/wire/mesh_readers.hpp"
#include "common/wire/polygon_sink.hpp"

namespace multitetra {

// Reads numbers and words from text or bytes; throws MeshFileError if they end too early.
class MeshBytes {
 public:
  explicit MeshBytes(std::string_view rest) : rest_(rest) {}

  [[nodiscard]] std::size_t size() const { return rest_.size(); }
  [[nodiscard]] bool is_empty() const { return rest_.empty(); }

  std::string_view take(std::size_t bytes) {
    if (bytes > rest_.size()) throw MeshFileError("it ends too early", kGetCompleteCopy);
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }
  template <typename Number>
  Number take_number(bool is_big_endian = false) {
    std::string bytes(take(sizeof(Number)));
    if (is_big_endian) bytes = std::string(bytes.rbegin(), bytes.rend());
    Number number;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  // Returns the text up to the end of the line, which is skipped; empty at the end.
  std::string_view take_line() { return multitetra::take_line(rest_); }
  // The same for text alone, where a carriage return by itself ends a line, too.
  std::string_view take_text_line();
  // Returns the next word between white space, across lines; empty at the end.
  std::string_view take_word();
  // Reads a word that must be a number.
  double take_decimal();

 private:
  std::string_view rest_;
};
static_assert(std::endian::native == std::endian::little);

// Throw MeshFileError unless the whole word is a number.
[[nodiscard]] double decimal_from(std::string_view word);
[[nodiscard]] std::int64_t integer_from(std::string_view word);

}  // namespace multitetra

#include "server/volume/formats/detail/text_slices.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kTextPortionBytes = std::size_t{1} << 16;
constexpr std::string_view kBetweenNumbers = " \t\r\n\v\f,";

// Converts a number beyond the range of its type: to 0 or infinity.
template <typename Number>
Number rounded_out_of_range(std::string_view word) {
  double wide = 0;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), wide);
  if (result.ec == std::errc()) return static_cast<Number>(wide);
  if (word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos) {
    return 0;
  }
  constexpr Number kInfinity = std::numeric_limits<Number>::infinity();
  return word.starts_with('-') ? -kInfinity : kInfinity;
}

// Fortran writes 0.12D-03, and an exponent of three digits without its letter: 1.23456-101. Returns
// such a number as others write it; empty for all others.
std::string without_fortran(std::string_view word) {
  const std::size_t letter = word.find_first_of("dD");
  const std::size_t sign = word.find_last_of("+-");
  const bool has_no_letter = word.find_first_of("eE") == std::string_view::npos &&
                             sign != std::string_view::npos && sign > 0 &&
                             sign + 4 == word.size() && word.find('.') < sign;
  std::string plain(word);
  if (letter != std::string_view::npos) {
    plain[letter] = 'e';
  } else if (has_no_letter) {
    plain.insert(sign, "e");
  } else {
    return {};
  }
  return plain;
}

class TextSlices : public StoredSlices {
 public:
  TextSlices(NumbersInText numbers, const ImageHeader& header)
      : numbers_(std::move(numbers)),
        file_(numbers_.file),
        type_(header.type),
        slice_numbers_(header.slice_bytes() / bytes_of(header.type)),
        slices_(static_cast<std::size_t>(header.dims[2])) {
    if (numbers_.end == 0) {
      numbers_.end = is_packed() ? std::numeric_limits<std::uint64_t>::max()
                                 : std::max(file_.size(), numbers_.begin);
    }
    begin_anew();
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::uint64_t wanted = numbers_.skipped + first * slice_numbers_;
    if (wanted < next_) begin_anew();
    while (next_ < wanted) next_word();
    for (std::uint64_t i = 0; i < count * slice_numbers_; ++i) {
      store(next_word(), into + i * bytes_of(type_));
    }
    if (first + count != slices_) return;
    if (numbers_.are_all && find_word()) has_more_ = true;
    if (is_packed()) stream_->require_good_end();
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    if (!has_more_) return {};
    return {"'" + file_.path().string() +
            "' has more numbers than the header declares. The last ones are ignored."};
  }

 private:
  [[nodiscard]] bool is_packed() const { return numbers_.packing != Packing::kNone; }

  void begin_anew() {
    at_ = numbers_.begin;
    next_ = 0;
    text_.clear();
    used_ = 0;
    if (!is_packed()) return;
    stream_.emplace(file_, 0, numbers_.packing);
    std::vector<std::byte> before(numbers_.begin);
    (void)stream_->read_some(before);
  }

  void read_portion(std::span<std::byte> into) {
    if (!is_packed()) {
      file_.read(at_, into);
      at_ += into.size();
      return;
    }
    const std::size_t got = stream_->read_some(into);
    at_ += got;
    if (got == into.size()) return;
    text_.resize(text_.size() - (into.size() - got));
    numbers_.end = at_;
  }

  std::string_view next_word() {
    if (const std::optional<std::string_view> word = find_word()) return *word;
    fail_damaged(file_.path(), "after " + std::to_string(next_) + " numbers it ends or is damaged");
  }

  // Returns nullopt at the end, or where no number is.
  std::optional<std::string_view> find_word() {
    while (true) {
      used_ = std::min(text_.find_first_not_of(kBetweenNumbers, used_), text_.size());
      const std::size_t end = text_.find_first_of(kBetweenNumbers, used_);
      if (used_ < text_.size() && (end != std::string::npos || at_ == numbers_.end)) {
        const std::string_view word = std::string_view(text_).substr(used_, end - used_);
        used_ = std::min(end, text_.size());
        ++next_;
        return word;
      }
      text_.erase(0, used_);
      used_ = 0;
      if (at_ >= numbers_.end || text_.size() > kTextPortionBytes) return std::nullopt;
      const std::size_t before = text_.size();
      text_.resize(before + std::min<std::uint64_t>(kTextPortionBytes, numbers_.end - at_));
      read_portion(std::as_writable_bytes(std::span(text_).subspan(before)));
    }
  }

  template <typename Number>
  void store_as(std::string_view word, std::byte* into) const {
    Number number{};
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    bool is_number = error == std::errc() && end == digits.data() + digits.size();
    if constexpr (std::is_floating_point_v<Number>) {
      if (error == std::errc::result_out_of_range && end == digits.data() + digits.size()) {
        number = rounded_out_of_range<Number>(digits);
        is_number = true;
      }
    }
    if constexpr (std::is_floating_point_v<Number>) {
      const std::string plain = is_number ? std::string() : without_fortran(digits);
      if (!plain.empty()) return store_as<Number>(plain, into);
    }
    if (!is_number) {
      fail_reading(file_.path(),
                   "'" + std::string(word.substr(0, 40)) + "' is not a number of type " +
                       std::string(name(type_)),
                   "Correct the file");
    }
    std::memcpy(into, &number, sizeof(number));
  }

  void store(std::string_view word, std::byte* into) const {
    with_number_type(type_, [&]<typename Number>() { store_as<Number>(word, into); });
  }

  NumbersInText numbers_;
  InputFile file_;
  StoredType type_;
  std::uint64_t slice_numbers_;
  std::size_t slices_;
  bool has_more_ = false;                                // Something follows the last number.
  std::optional<UnpackedStream> stream_ = std::nullopt;  // Absent if the file is not compressed.
  std::uint64_t at_ = 0;                                 // File offset of the byte after text_.
  std::string text_;
  // Number of bytes of text_ that were used.
  std::size_t used_ = 0;
  std::uint64_t next_ = 0;  // Index of the next number, counted from the first in the text.
};

}  // namespace

std::unique_ptr<StoredSlices> text_slices(NumbersInText numbers, const ImageHeader& header) {
  return std::make_unique<TextSlices>(std::move(numbers), header);
}

}  // namespace multitetra

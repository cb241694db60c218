// Converts the numbers stored in files to the samples of a volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "server/core/framework/volume.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

using Notice = std::function<void(const std::string&)>;

// Resizes to `count` samples of `type`; their values are unspecified. Reuses the memory if
// `samples` has the same type.
void resize(Samples& samples, SampleType type, std::size_t count);
// How much of a volume's range of values conversion to f32 may lose.
enum class AllowedLoss { kHundredth, kAny };

// Returns the address of the first sample.
[[nodiscard]] std::byte* bytes_of(Samples& samples);

// Replaces infinite samples, which have no place on a surface, by void (NaN). Returns their number.
std::uint64_t make_infinite_void(std::span<float> samples);

// Converts the stored numbers of one volume to samples. Integers of 8 and 16 bits and f32 keep
// their type and bits. Slope, intercept and the choice of a component are applied; the result stays
// an integer if it is exact (slope 1, integer intercept) and fits an integer type, else it becomes
// f32. 16-bit values with an intercept stay 16-bit, as CT scanners intend: the few values out of
// range (padding) are clamped.
class SampleConversion {
 public:
  // Throws VolumeFileError if samples have several components and no valid one is chosen.
  SampleConversion(std::filesystem::path file, const ImageHeader& header, ComponentChoice choice);

  [[nodiscard]] SampleType type() const { return type_; }
  // Returns whether stored numbers are used unchanged. (They may still be infinite.)
  [[nodiscard]] bool is_none() const { return is_none_; }

  // Converts `count` stored samples to the samples from `first` on. Requires !is_none() and that
  // `into` is of type().
  void convert(const std::byte* stored, std::size_t count, Samples& into, std::size_t first);

  // Throws VolumeFileError if f32 loses more than a hundredth of the range of the values converted
  // so far, or of this range without the least and the greatest value, or can hold none of them, or
  // cannot hold several of different values.
  void require_small_loss() const;
  // Returns PhysicalMeaning::rounding of the values converted so far.
  [[nodiscard]] std::string rounding() const;
  // Reports rounding and clamping, if any.
  void report(const Notice& notice) const;

 private:
  template <typename Stored>
  void convert_from(const std::byte* stored, std::size_t count, Samples& into, std::size_t first);
  template <typename Stored>
  [[nodiscard]] double value_of(const std::byte* sample) const;

  // What f32 loses of a range of values.
  struct Loss {
    double low = 0;
    double range = 0;  // 0: no loss counts.
    double error = 0;  // The largest within it.
    const char* error_text = "";
    const char* range_text = "";

    [[nodiscard]] double share() const { return range > 0 ? error / range : 0; }
  };
  struct ConvertedValue {
    double value;
    double error;
    std::uint64_t order;  // As if random.
  };
  void note(double value, double error);
  // Returns that of all values converted so far, or of those between the least and the greatest if
  // that is more than twice the share: missing samples often have a value that is far from the
  // others.
  [[nodiscard]] Loss loss() const;
  [[nodiscard]] Loss loss_between_ends() const;

  std::filesystem::path file_;
  ImageHeader header_;
  ComponentChoice choice_;
  SampleType type_ = SampleType::kU8;
  bool is_none_ = false;
  // The largest rounding error of a conversion to f32.
  double largest_error_ = 0;
  // The range of values converted to f32.
  double least_ = std::numeric_limits<double>::infinity();
  double greatest_ = -std::numeric_limits<double>::infinity();
  // Those of the values converted to f32 whose order is at most this.
  std::vector<ConvertedValue> some_ = {};
  std::uint64_t last_order_ = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t converted_ = 0;
  // Finite values beyond f32, which become void: their number and range.
  std::uint64_t too_large_ = 0;
  double least_too_large_ = std::numeric_limits<double>::infinity();
  double greatest_too_large_ = -std::numeric_limits<double>::infinity();
  std::uint64_t saturated_ = 0;  // Number of clamped values.
};

// Reports that void replaces infinite samples, with the words kInfiniteNotice, if there are any.
void report_infinite(const Notice& notice, const std::filesystem::path& file,
                     std::uint64_t infinite);

}  // namespace multitetra

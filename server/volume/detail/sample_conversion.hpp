// From the numbers that files have to the samples of a volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "server/core/framework/volume.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

using Notice = std::function<void(const std::string&)>;

// Makes room for `count` samples of `type`. What `samples` held is lost; its memory is used again
// when it is of the same type.
void resize(Samples& samples, SampleType type, std::size_t count);
// The first byte of the samples.
[[nodiscard]] std::byte* bytes_of(Samples& samples);

// Infinity is no place on a surface's way: such samples become void (NaN). Returns how many.
std::uint64_t make_infinite_void(std::span<float> samples);

// Converts the stored numbers of one volume to samples. Integers of 8 and 16 bits and f32 keep
// their type and their bits. Slope, intercept and the choice of a component are applied; the result
// keeps an integer type where it is exact (slope 1, whole intercept) and fits one, and is f32 else.
// Values of 16 bits and an intercept stay 16 bits, as CT scanners mean them: the few beyond
// (padding) become the least or the greatest.
class SampleConversion {
 public:
  // Throws VolumeFileError when the samples have several components and none is chosen, or one that
  // they do not have.
  SampleConversion(std::filesystem::path file, const ImageHeader& header, ComponentChoice choice);

  [[nodiscard]] SampleType type() const { return type_; }
  // Whether stored numbers are samples as they are. (They may be infinite all the same.)
  [[nodiscard]] bool is_none() const { return is_none_; }

  // Converts `count` stored samples into the samples from `first` on. Requires !is_none() and that
  // `into` is of type().
  void convert(const std::byte* stored, std::size_t count, Samples& into, std::size_t first);

  // Reports what happened to the converted samples, if anything did.
  void report(const Notice& notice) const;

 private:
  template <typename Stored>
  void convert_from(const std::byte* stored, std::size_t count, Samples& into, std::size_t first);
  template <typename Stored>
  [[nodiscard]] double value_of(const std::byte* sample) const;

  std::filesystem::path file_;
  ImageHeader header_;
  ComponentChoice choice_;
  SampleType type_ = SampleType::kU8;
  bool is_none_ = false;
  // The largest rounding error of a value that became f32.
  double largest_error_ = 0;
  std::uint64_t saturated_ = 0;  // Values beyond their integer type.
};

void report_infinite(const Notice& notice, const std::filesystem::path& file,
                     std::uint64_t infinite);

}  // namespace multitetra

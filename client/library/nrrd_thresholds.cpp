#include "client/library/nrrd_thresholds.hpp"

#include <zlib.h>
#include <cerrno>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/open_file.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/dataset/length_units.hpp"
#include "common/image/nrrd_header.hpp"
#include "common/image/nrrd_placement.hpp"
#include "common/image/stored_type.hpp"
#include "common/request/threshold_shrinking.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxSamples = std::uint64_t{1} << 29;  // Two gigabytes of floats.
constexpr std::uint64_t kMaxNrrdFileBytes = std::uint64_t{1} << 33;

// Describes what is wrong with the file; caught by read_nrrd_thresholds().
class NrrdFault : public std::runtime_error {
 public:
  explicit NrrdFault(const std::string& problem,
                     const std::string& remedy = "give a complete NRRD file",
                     ErrorCode code = ErrorCode::kInvalidArgument)
      : std::runtime_error(problem + "; " + remedy + "."), code_(code) {}
  [[nodiscard]] ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

// Returns the numbers separated by white space, commas or parentheses; skips "none".
std::vector<double> numbers_in(std::string_view text) {
  constexpr std::string_view kBetween = " \t\r\n(),";
  std::vector<double> numbers;
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kBetween), text.size()));
    if (text.empty()) return numbers;
    std::string_view word = text.substr(0, text.find_first_of(kBetween));
    text.remove_prefix(word.size());
    if (word == "none") continue;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto number = parse_number<double>(word);
    if (!number) throw NrrdFault("\"" + std::string(word.substr(0, 40)) + "\" is not a number");
    numbers.push_back(*number);
  }
}

std::vector<double> numbers_of(const NrrdHeader& header, std::string_view field) {
  return numbers_in(header.field(field));
}

std::int64_t integer_of(const NrrdHeader& header, std::string_view field, std::int64_t otherwise) {
  return parse_number<std::int64_t>(header.field(field)).value_or(otherwise);
}

StoredType type_of(const NrrdHeader& header) {
  const std::string word = header.field("type");
  if (const auto type = stored_type_from_word(word)) return *type;
  throw NrrdFault("its type is \"" + word.substr(0, 40) + "\"",
                  "give integers or floating-point numbers");
}

// Leading axes of size 1, such as the vector axis of scalars, are ignored.
std::array<std::int32_t, 3> dims_of(const NrrdHeader& header) {
  std::vector<double> sizes = numbers_of(header, "sizes");
  if (static_cast<std::int64_t>(sizes.size()) != integer_of(header, "dimension", -1)) {
    throw NrrdFault("the number of its sizes differs from its dimension");
  }
  while (sizes.size() > 3 && sizes.front() == 1) sizes.erase(sizes.begin());
  while (sizes.size() > 3 && sizes.back() == 1) sizes.pop_back();
  if (sizes.size() < 2 || sizes.size() > 3) {
    throw NrrdFault("it has " + std::to_string(sizes.size()) + " dimensions",
                    "give a volume with one number per sample");
  }
  std::array<std::int32_t, 3> dims = {1, 1, 1};
  double samples = 1;
  for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
    if (!(sizes[axis] >= 1 && sizes[axis] <= static_cast<double>(kMaxSamples)) ||
        sizes[axis] != std::floor(sizes[axis])) {
      throw NrrdFault("its sizes are not valid numbers of samples");
    }
    dims[axis] = static_cast<std::int32_t>(sizes[axis]);
    samples *= sizes[axis];
  }
  if (samples > static_cast<double>(kMaxSamples)) {
    throw NrrdFault("it has more than 2^29 samples",
                    "give a coarser grid, with the smallest threshold of each block",
                    ErrorCode::kLimitExceeded);
  }
  return dims;
}

// Maps indices to the world, in which lengths have the unit `length_unit`.
Affine map_of(const NrrdHeader& header, const std::string& length_unit) {
  std::vector<std::int64_t> sizes;
  for (const double size : numbers_of(header, "sizes")) {
    sizes.push_back(static_cast<std::int64_t>(size));
  }
  std::vector<std::size_t> axes;  // As many as dims_of() has, without those at the ends.
  std::size_t begin = 0;
  std::size_t end = sizes.size();
  while (end - begin > 3 && sizes[begin] == 1) ++begin;
  while (end - begin > 3 && sizes[end - 1] == 1) --end;
  for (; begin < end; ++begin) axes.push_back(begin);
  const auto placement = nrrd_placement(header, sizes, axes);
  if (!placement) {
    throw NrrdFault(placement.error().text,
                    "use left-posterior-superior, right-anterior-superior or "
                    "left-anterior-superior");
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    for (const char* const field : {"space directions", "spacings"}) {
      if (header.field(field).empty() || length(placement->steps[i]) > 0) continue;
      const std::vector<std::string> words = header.axis_words(field, sizes.size());
      const std::string word = words.empty() ? "" : lower_case(words[axes[i]]);
      if (word != "none" && word != "nan") {
        throw NrrdFault(std::string("its field '") + field + "' does not place its axis " +
                            std::to_string(axes[i] + 1),
                        "give a value for each axis, vectors as (1,0,0)");
      }
    }
  }
  const std::string unit = placement->unit.empty() && placement->signs ? "mm" : placement->unit;
  Affine map;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string& own = unit.empty() ? placement->units_of_axes[axis] : unit;
    const double factor = length_factor(unit_from(own), length_unit).value_or(1);
    const bool is_stated = length(placement->steps[axis]) > 0;
    map.columns[axis] = scaled(is_stated ? placement->steps[axis] : map.columns[axis], factor);
    map.translation[axis] = factor * placement->first[axis].value_or(0);
  }
  return map;
}

std::string contents_of(const fs::path& file) {
  const OpenFile opened(file);
  if (!opened.is_open() && errno != ENOENT) throw NrrdFault("it cannot be read");
  const auto size = opened.regular_size();
  if (!size) throw NrrdFault("the file does not exist", "check its name");
  auto bytes = opened.content(kMaxNrrdFileBytes);
  if (!bytes || *size > kMaxNrrdFileBytes) throw NrrdFault("it cannot be read");
  return *std::move(bytes);
}

// Decompresses at most `max_bytes` bytes of the stream.
std::string unzipped(std::string_view packed, std::uint64_t max_bytes) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw std::bad_alloc();  // Accepts gzip and zlib.
  std::string plain;
  int status = Z_OK;
  constexpr std::uint64_t kPortion = std::uint64_t{1} << 20;
  std::vector<char> portion(kPortion);
  while (status == Z_OK && plain.size() < max_bytes) {
    const std::uint64_t room = std::min(kPortion, max_bytes - plain.size());
    stream.next_out = reinterpret_cast<Bytef*>(portion.data());
    stream.avail_out = static_cast<uInt>(room);
    if (stream.avail_in == 0) {
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
      stream.avail_in = static_cast<uInt>(std::min(packed.size(), std::size_t{1} << 30));
      packed.remove_prefix(stream.avail_in);
    }
    status = inflate(&stream, Z_NO_FLUSH);
    plain.append(portion.data(), room - stream.avail_out);
  }
  inflateEnd(&stream);
  if (status != Z_OK && status != Z_STREAM_END)
    throw NrrdFault("its compressed samples are damaged");
  return plain;
}

template <typename Number>
void convert(std::string_view bytes, bool is_big_endian, std::vector<float>& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::array<char, sizeof(Number)> one;
    std::memcpy(one.data(), bytes.data() + i * sizeof(Number), sizeof(Number));
    if (is_big_endian) std::reverse(one.begin(), one.end());
    Number number;
    std::memcpy(&number, one.data(), sizeof number);
    samples[i] = static_cast<float>(number);
  }
}

std::vector<float> samples_of(std::string_view bytes, const NrrdHeader& header, StoredType type,
                              std::size_t count) {
  if (bytes.size() < count * bytes_of(type)) {
    throw NrrdFault("it ends after " + std::to_string(bytes.size()) + " of " +
                    std::to_string(count * bytes_of(type)) + " bytes of samples");
  }
  const std::string endian = lower_case(header.field("endian"));
  if (bytes_of(type) > 1 && endian != "little" && endian != "big") {
    throw NrrdFault("its header does not state the byte order (endian) of its samples");
  }
  std::vector<float> samples(count);
  with_number_type(type,
                   [&]<typename Number>() { convert<Number>(bytes, endian == "big", samples); });
  return samples;
}

std::string_view without_lines(std::string_view bytes, std::int64_t lines) {
  for (; lines > 0; --lines) {
    const std::size_t end = bytes.find('\n');
    if (end == std::string_view::npos) throw NrrdFault("it has fewer lines than its header skips");
    bytes.remove_prefix(end + 1);
  }
  return bytes;
}

std::string_view without_bytes(std::string_view bytes, std::int64_t count) {
  if (count < 0 || static_cast<std::uint64_t>(count) > bytes.size()) {
    throw NrrdFault("it has fewer bytes than its header skips");
  }
  return bytes.substr(static_cast<std::size_t>(count));
}

std::vector<float> read_samples(std::string_view bytes, const NrrdHeader& header,
                                std::size_t count) {
  const StoredType type = type_of(header);
  const std::string encoding = lower_case(header.field("encoding"));
  const std::int64_t skip = integer_of(header, "byte skip", 0);
  bytes = without_lines(bytes, integer_of(header, "line skip", 0));
  if (encoding == "raw") {
    if (skip != -1) return samples_of(without_bytes(bytes, skip), header, type, count);
    // Skip -1: the samples end the file.
    const std::size_t needed = std::min(bytes.size(), count * bytes_of(type));
    return samples_of(bytes.substr(bytes.size() - needed), header, type, count);
  }
  if (encoding == "gzip" || encoding == "gz") {
    const auto more = static_cast<std::uint64_t>(std::max<std::int64_t>(skip, 0));
    const std::string plain = unzipped(bytes, count * bytes_of(type) + more);
    return samples_of(without_bytes(plain, skip), header, type, count);
  }
  if (encoding == "ascii" || encoding == "text" || encoding == "txt") {
    const std::vector<double> numbers = numbers_in(without_bytes(bytes, skip));
    if (numbers.size() < count) {
      throw NrrdFault("it has " + std::to_string(numbers.size()) + " of " + std::to_string(count) +
                      " samples");
    }
    return {numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  throw NrrdFault("its encoding is \"" + encoding.substr(0, 40) + "\"",
                  "save it as raw, gzip or ascii");
}

// Returns the file that contains the samples; empty if they follow the header.
fs::path data_file_of(const NrrdHeader& header, const fs::path& file) {
  const std::string name = header.field("data file");
  if (name.empty()) return {};
  if (name.starts_with("LIST") || name.find('%') != std::string::npos || name == "-") {
    throw NrrdFault("its samples are in several files", "save it as one file");
  }
  if (fs::path(name).has_parent_path()) {
    throw NrrdFault("its samples are in another folder", "put both files into one folder");
  }
  return file.parent_path() / name;
}

}  // namespace

Result<ThresholdGrid> read_nrrd_thresholds(const fs::path& file, double elsewhere,
                                           const std::string& length_unit) {
  try {
    const std::string bytes = contents_of(file);
    if (!bytes.starts_with("NRRD")) throw NrrdFault("it is not an NRRD file", "give an NRRD file");
    const NrrdHeader header =
        parse_nrrd_header(std::string_view(bytes).substr(0, kMaxNrrdHeaderBytes));
    const std::array<std::int32_t, 3> dims = dims_of(header);
    const std::size_t count = static_cast<std::size_t>(dims[0]) *
                              static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
    const fs::path data_file = data_file_of(header, file);
    const std::vector<float> samples =
        data_file.empty()
            ? read_samples(std::string_view(bytes).substr(header.bytes), header, count)
            : read_samples(contents_of(data_file), header, count);
    return shrunk(
        {.dims = dims, .index_to_world = map_of(header, length_unit), .thresholds = samples},
        elsewhere);
  } catch (const NrrdFault& fault) {
    return fail(fault.code(),
                "Cannot read the threshold grid \"" + file.string() + "\": " + fault.what());
  }
}

}  // namespace multitetra

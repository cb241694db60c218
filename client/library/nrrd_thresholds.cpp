#include "client/library/nrrd_thresholds.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/text.hpp"
#include "common/request/threshold_shrinking.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostSamples = std::uint64_t{1} << 29;  // Two gigabytes of floats.
constexpr std::uint64_t kMostFileBytes = std::uint64_t{1} << 33;

// What is wrong with the file, for read_nrrd_thresholds().
class NrrdFault : public std::runtime_error {
 public:
  explicit NrrdFault(const std::string& problem,
                     const std::string& remedy = "give a whole NRRD file",
                     ErrorCode code = ErrorCode::kInvalidArgument)
      : std::runtime_error(problem + "; " + remedy + "."), code_(code) {}
  [[nodiscard]] ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

enum class NrrdType { kI8, kU8, kI16, kU16, kI32, kU32, kI64, kU64, kF32, kF64 };

struct NrrdTypeNames {
  NrrdType type;
  std::size_t bytes;
  std::vector<std::string_view> names;
};
const std::vector<NrrdTypeNames>& nrrd_types() {
  static const std::vector<NrrdTypeNames> types = {
      {NrrdType::kI8, 1, {"signed char", "int8", "int8_t"}},
      {NrrdType::kU8, 1, {"uchar", "unsigned char", "uint8", "uint8_t"}},
      {NrrdType::kI16,
       2,
       {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
      {NrrdType::kU16, 2, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
      {NrrdType::kI32, 4, {"int", "signed int", "int32", "int32_t"}},
      {NrrdType::kU32, 4, {"uint", "unsigned int", "uint32", "uint32_t"}},
      {NrrdType::kI64,
       8,
       {"longlong", "long long", "long long int", "signed long long", "signed long long int",
        "int64", "int64_t"}},
      {NrrdType::kU64,
       8,
       {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"}},
      {NrrdType::kF32, 4, {"float"}},
      {NrrdType::kF64, 8, {"double"}}};
  return types;
}

// Numbers between white space, commas and parentheses; "none" is left out.
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
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size()) {
      throw NrrdFault("\"" + std::string(word.substr(0, 40)) + "\" is no number");
    }
    numbers.push_back(number);
  }
}

class NrrdHeader {
 public:
  // Takes the lines up to the first empty one from `text`.
  explicit NrrdHeader(std::string_view& text) {
    if (take_line(text).substr(0, 4) != "NRRD") {
      throw NrrdFault("it is no NRRD file", "give a NRRD file");
    }
    while (!text.empty()) {
      const std::string_view line = take_line(text);
      if (line.empty()) return;
      const std::size_t colon = line.find(": ");
      if (line.starts_with('#') || colon == std::string_view::npos) continue;
      std::string name = lower_case(line.substr(0, colon));
      std::erase(name, ' ');  // "data file" is "datafile" as well.
      fields_[name] = trimmed(line.substr(colon + 2));
    }
  }

  [[nodiscard]] std::string_view operator[](const char* name) const {
    const auto found = fields_.find(name);
    return found == fields_.end() ? std::string_view() : std::string_view(found->second);
  }
  [[nodiscard]] std::vector<double> numbers(const char* name) const {
    return numbers_in((*this)[name]);
  }
  [[nodiscard]] std::int64_t integer(const char* name, std::int64_t otherwise) const {
    const std::vector<double> values = numbers(name);
    return values.size() == 1 && std::abs(values[0]) < 1e15 ? static_cast<std::int64_t>(values[0])
                                                            : otherwise;
  }

 private:
  static std::string_view take_line(std::string_view& text) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  std::map<std::string, std::string, std::less<>> fields_;
};

const NrrdTypeNames& type_of(const NrrdHeader& header) {
  const std::string wanted = lower_case(header["type"]);
  for (const NrrdTypeNames& type : nrrd_types()) {
    if (std::find(type.names.begin(), type.names.end(), wanted) != type.names.end()) return type;
  }
  throw NrrdFault("its type is \"" + wanted.substr(0, 40) + "\"",
                  "give integers or floating-point numbers");
}

// Axes of one sample in front, as of a list of one number a place, count for nothing.
std::array<std::int32_t, 3> dims_of(const NrrdHeader& header) {
  std::vector<double> sizes = header.numbers("sizes");
  if (static_cast<std::int64_t>(sizes.size()) != header.integer("dimension", -1)) {
    throw NrrdFault("its sizes are not those of its dimensions");
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
    if (!(sizes[axis] >= 1 && sizes[axis] <= static_cast<double>(kMostSamples)) ||
        sizes[axis] != std::floor(sizes[axis])) {
      throw NrrdFault("its sizes are no numbers of samples");
    }
    dims[axis] = static_cast<std::int32_t>(sizes[axis]);
    samples *= sizes[axis];
  }
  if (samples > static_cast<double>(kMostSamples)) {
    throw NrrdFault("it has more than 2^29 samples",
                    "give a coarser one, of the least threshold of each block",
                    ErrorCode::kLimitExceeded);
  }
  return dims;
}

Affine map_of(const NrrdHeader& header) {
  Affine map;
  const auto misplaced = [] { return NrrdFault("its place in the world is not understood"); };
  const std::vector<double> directions = header.numbers("spacedirections");
  const std::vector<double> spacings = header.numbers("spacings");
  const std::vector<double> origin =
      header.numbers(directions.empty() ? "axismins" : "spaceorigin");
  const std::size_t axes = directions.size() == 4 ? 2 : 3;
  if (!directions.empty()) {
    if (directions.size() != axes * axes && directions.size() != 6) throw misplaced();
    const std::size_t rows = directions.size() == 6 ? 3 : axes;
    for (std::size_t i = 0; i < directions.size(); ++i) {
      if (i % rows == 0) map.columns[i / rows] = {0, 0, 0};
      map.columns[i / rows][i % rows] = directions[i];
    }
  } else {
    if (spacings.size() > 3) throw misplaced();
    for (std::size_t axis = 0; axis < spacings.size(); ++axis) {
      if (std::isfinite(spacings[axis])) map.columns[axis][axis] = spacings[axis];
    }
  }
  if (origin.size() > 3) throw misplaced();
  for (std::size_t axis = 0; axis < origin.size(); ++axis) {
    if (std::isfinite(origin[axis])) map.translation[axis] = origin[axis];
  }
  // World coordinates of patients are LPS, as the server's are.
  const std::string space = lower_case(header["space"]);
  const bool is_right = space == "ras" || space == "right-anterior-superior";
  const bool is_anterior = is_right || space == "las" || space == "left-anterior-superior";
  const auto turn = [&](std::size_t axis) {
    for (Vec3& column : map.columns) column[axis] = 0.0 - column[axis];  // No -0.
    map.translation[axis] = 0.0 - map.translation[axis];
  };
  if (is_right) turn(0);
  if (is_anterior) turn(1);
  return map;
}

std::string contents_of(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none)) {
    throw NrrdFault("there is no such file", "check its name");
  }
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(in.tellg(), 0));
  if (!in || size > kMostFileBytes) throw NrrdFault("its bytes cannot be read");
  std::string bytes(size, '\0');
  in.seekg(0);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size))) {
    throw NrrdFault("its bytes cannot be read");
  }
  return bytes;
}

// At most `most` bytes of the stream.
std::string unzipped(std::string_view packed, std::uint64_t most) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw std::bad_alloc();  // gzip or zlib.
  std::string plain;
  int status = Z_OK;
  constexpr std::uint64_t kPortion = std::uint64_t{1} << 20;
  std::vector<char> portion(kPortion);
  while (status == Z_OK && plain.size() < most) {
    const std::uint64_t room = std::min(kPortion, most - plain.size());
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
  if (status != Z_OK && status != Z_STREAM_END) throw NrrdFault("its packed samples are damaged");
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

std::vector<float> samples_of(std::string_view bytes, const NrrdHeader& header,
                              const NrrdTypeNames& type, std::size_t count) {
  if (bytes.size() < count * type.bytes) {
    throw NrrdFault("it ends after " + std::to_string(bytes.size()) + " of " +
                    std::to_string(count * type.bytes) + " bytes of samples");
  }
  const std::string endian = lower_case(header["endian"]);
  if (type.bytes > 1 && endian != "little" && endian != "big") {
    throw NrrdFault("its header does not name the byte order (endian) of its samples");
  }
  const bool is_big = endian == "big";
  std::vector<float> samples(count);
  switch (type.type) {
    case NrrdType::kI8:
      convert<std::int8_t>(bytes, is_big, samples);
      break;
    case NrrdType::kU8:
      convert<std::uint8_t>(bytes, is_big, samples);
      break;
    case NrrdType::kI16:
      convert<std::int16_t>(bytes, is_big, samples);
      break;
    case NrrdType::kU16:
      convert<std::uint16_t>(bytes, is_big, samples);
      break;
    case NrrdType::kI32:
      convert<std::int32_t>(bytes, is_big, samples);
      break;
    case NrrdType::kU32:
      convert<std::uint32_t>(bytes, is_big, samples);
      break;
    case NrrdType::kI64:
      convert<std::int64_t>(bytes, is_big, samples);
      break;
    case NrrdType::kU64:
      convert<std::uint64_t>(bytes, is_big, samples);
      break;
    case NrrdType::kF32:
      convert<float>(bytes, is_big, samples);
      break;
    case NrrdType::kF64:
      convert<double>(bytes, is_big, samples);
      break;
  }
  return samples;
}

std::string_view without_lines(std::string_view bytes, std::int64_t lines) {
  for (; lines > 0; --lines) {
    const std::size_t end = bytes.find('\n');
    if (end == std::string_view::npos) throw NrrdFault("it has fewer lines than are to be skipped");
    bytes.remove_prefix(end + 1);
  }
  return bytes;
}

std::string_view without_bytes(std::string_view bytes, std::int64_t count) {
  if (count < 0 || static_cast<std::uint64_t>(count) > bytes.size()) {
    throw NrrdFault("it has fewer bytes than are to be skipped");
  }
  return bytes.substr(static_cast<std::size_t>(count));
}

std::vector<float> read_samples(std::string_view bytes, const NrrdHeader& header,
                                std::size_t count) {
  const NrrdTypeNames& type = type_of(header);
  const std::string encoding = lower_case(header["encoding"]);
  const std::int64_t skip = header.integer("byteskip", 0);
  bytes = without_lines(bytes, header.integer("lineskip", 0));
  if (encoding == "raw") {
    if (skip != -1) return samples_of(without_bytes(bytes, skip), header, type, count);
    const std::size_t needed = std::min(bytes.size(), count * type.bytes);  // They end the file.
    return samples_of(bytes.substr(bytes.size() - needed), header, type, count);
  }
  if (encoding == "gzip" || encoding == "gz") {
    const auto more = static_cast<std::uint64_t>(std::max<std::int64_t>(skip, 0));
    const std::string plain = unzipped(bytes, count * type.bytes + more);
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

// The file with the samples; empty: they follow the header.
fs::path data_file_of(const NrrdHeader& header, const fs::path& file) {
  const std::string name(header["datafile"]);
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

Result<ThresholdGrid> read_nrrd_thresholds(const fs::path& file, double elsewhere) {
  try {
    const std::string bytes = contents_of(file);
    std::string_view rest = bytes;
    const NrrdHeader header(rest);
    const std::array<std::int32_t, 3> dims = dims_of(header);
    const std::size_t count = static_cast<std::size_t>(dims[0]) *
                              static_cast<std::size_t>(dims[1]) * static_cast<std::size_t>(dims[2]);
    const fs::path data_file = data_file_of(header, file);
    const std::vector<float> samples = data_file.empty()
                                           ? read_samples(rest, header, count)
                                           : read_samples(contents_of(data_file), header, count);
    return shrunk({.dims = dims, .index_to_world = map_of(header), .thresholds = samples},
                  elsewhere);
  } catch (const NrrdFault& fault) {
    return fail(fault.code(),
                "Cannot read the threshold grid \"" + file.string() + "\": " + fault.what());
  }
}

}  // namespace multitetra

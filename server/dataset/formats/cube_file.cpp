#include "server/dataset/formats/cube_file.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/dataset/formats/header_bytes.hpp"
#include "server/dataset/formats/input_file.hpp"
#include "server/dataset/formats/unpacking.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 20;
constexpr std::int64_t kMostAtoms = 100'000;

std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

std::vector<double> numbers_in(std::string_view line) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return numbers;
    line.remove_prefix(begin);
    const std::size_t length = std::min(line.find_first_of(" \t\r"), line.size());
    double number = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + length, number);
    if (error != std::errc() || end != line.data() + length || !std::isfinite(number)) return {};
    numbers.push_back(number);
    line.remove_prefix(length);
  }
}

// The grid's four lines: a count and a place or step each.
struct CubeGrid {
  std::int64_t atoms = 0;  // Negative: a line about orbitals follows the atoms.
  std::int64_t components = 1;
  Vec3 origin{};
  std::array<std::int64_t, 3> counts{};  // Negative: lengths are in Å.
  std::array<Vec3, 3> steps{};
};

std::optional<CubeGrid> grid_in(std::string_view& text) {
  next_line(text);
  next_line(text);
  CubeGrid grid;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<double> numbers = numbers_in(next_line(text));
    if (numbers.size() < 4 || numbers.size() > 5 || numbers[0] != std::round(numbers[0]) ||
        std::abs(numbers[0]) > 1e9) {
      return std::nullopt;
    }
    const auto count = static_cast<std::int64_t>(numbers[0]);
    const Vec3 vector = {numbers[1], numbers[2], numbers[3]};
    if (i == 0) {
      grid.atoms = count;
      grid.origin = vector;
      if (numbers.size() == 5 && (numbers[4] < 1 || numbers[4] > kMaxComponents))
        return std::nullopt;
      if (numbers.size() == 5) grid.components = static_cast<std::int64_t>(numbers[4]);
    } else {
      if (count == 0) return std::nullopt;
      grid.counts[i - 1] = count;
      grid.steps[i - 1] = vector;
    }
  }
  return grid;
}

// Reads the numbers in order; going back begins anew.
class CubeSlices : public StoredSlices {
 public:
  CubeSlices(const fs::path& file, std::uint64_t begin, const ImageHeader& header)
      : file_(file), packing_(whole_packing(file_)), begin_(begin), header_(header) {
    begin_anew();
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::uint64_t slice = header_.slice_bytes() / sizeof(float);
    if (first * slice < next_) begin_anew();
    while (next_ < first * slice) (void)next_number();
    for (std::uint64_t i = 0; i < count * slice; ++i) {
      const float number = next_number();
      std::memcpy(into + i * sizeof(float), &number, sizeof(float));
    }
    const bool is_last = first + count == static_cast<std::size_t>(header_.dims[2]);
    if (is_last && stream_) stream_->require_good_end();
  }

 private:
  float next_number() {
    constexpr std::string_view kSpace = " \t\r\n";
    constexpr std::size_t kLongestWord = 64;
    if (text_.size() - used_ < kLongestWord) refill();
    used_ = std::min(text_.find_first_not_of(kSpace, used_), text_.size());
    while (used_ == text_.size() && refill()) {
      used_ = std::min(text_.find_first_not_of(kSpace, used_), text_.size());
    }
    if (text_.size() - used_ < kLongestWord) refill();
    const std::size_t end = std::min(text_.find_first_of(kSpace, used_), text_.size());
    double number = 0;
    const auto [stop, error] = std::from_chars(text_.data() + used_, text_.data() + end, number);
    if (error == std::errc::result_out_of_range) number = 0;  // Densities far from every atom.
    if (used_ == end || stop != text_.data() + end ||
        (error != std::errc() && error != std::errc::result_out_of_range)) {
      fail_reading(file_.path(),
                   "after " + std::to_string(next_) + " numbers it ends or has '" +
                       text_.substr(used_, std::min<std::size_t>(end - used_, 40)) + "'",
                   "Get a whole copy of it");
    }
    used_ = end;
    ++next_;
    return static_cast<float>(number);
  }

  // Reads on, keeping what is not used; false at the end of the file.
  bool refill() {
    constexpr std::size_t kPortion = std::size_t{1} << 16;
    text_.erase(0, used_);
    used_ = 0;
    const std::size_t before = text_.size();
    text_.resize(before + kPortion);
    const std::size_t got = read_some(std::as_writable_bytes(std::span(text_).subspan(before)));
    text_.resize(before + got);
    at_ += got;
    return got > 0;
  }

  static Packing whole_packing(const InputFile& file) {
    const Packing packing = UnpackedStream::packing_at(file, 0);
    return packing == Packing::kGzip || packing == Packing::kBzip2 ? packing : Packing::kNone;
  }
  [[nodiscard]] std::size_t read_some(std::span<std::byte> into) {
    return stream_ ? stream_->read_some(into) : file_.read_some(at_, into);
  }
  void begin_anew() {
    next_ = 0;
    text_.clear();
    used_ = 0;
    at_ = begin_;
    if (packing_ == Packing::kNone) return;
    stream_.emplace(file_, 0, packing_);
    std::vector<std::byte> header(begin_);
    (void)stream_->read_some(header);
  }

  InputFile file_;
  Packing packing_;
  std::optional<UnpackedStream> stream_ = std::nullopt;  // None: the file is not packed.
  std::uint64_t begin_;
  std::uint64_t at_ = 0;
  ImageHeader header_;
  std::string text_;
  std::size_t used_ = 0;
  std::uint64_t next_ = 0;
};

}  // namespace

bool is_cube(std::string_view beginning) { return grid_in(beginning).has_value(); }

StoredVolume open_cube(const fs::path& path) {
  const InputFile file(path);
  const std::string beginning = unpacked_beginning(file, kMostHeaderBytes);
  std::string_view rest = beginning;
  const std::optional<CubeGrid> grid = grid_in(rest);
  if (!grid) fail_reading(path, "it is no cube file", "Get a whole copy of it");
  if (std::abs(grid->atoms) > kMostAtoms) {
    fail_reading(path, "it has " + std::to_string(grid->atoms) + " atoms",
                 "Get a whole copy of it");
  }
  for (std::int64_t i = 0; i < std::abs(grid->atoms); ++i) {
    if (numbers_in(next_line(rest)).size() != 5) {
      fail_reading(path, "the line of its atom " + std::to_string(i + 1) + " is no five numbers",
                   "Get a whole copy of it");
    }
  }
  std::int64_t components = grid->components;
  if (grid->atoms < 0) {  // The number of orbitals, then their numbers.
    const std::vector<double> orbitals = numbers_in(next_line(rest));
    if (orbitals.empty() || orbitals[0] < 1 || orbitals[0] > kMaxComponents ||
        orbitals.size() != static_cast<std::size_t>(orbitals[0]) + 1) {
      fail_reading(path, "the line of its orbitals is not understood",
                   "Write one orbital to a file");
    }
    components = static_cast<std::int64_t>(orbitals[0]);
  }
  ImageHeader header{
      .type = StoredType::kF32,
      .meaning = {.length_unit = grid->counts[0] < 0 ? "Å" : "bohr", .value_unit = {}},
      .components = components};
  for (std::size_t axis = 0; axis < 3; ++axis) header.dims[axis] = std::abs(grid->counts[2 - axis]);
  set_axes(path, header, {grid->steps[2], grid->steps[1], grid->steps[0]}, grid->origin);
  check_header(path, header);
  const auto begin = static_cast<std::uint64_t>(beginning.size() - rest.size());
  return {.header = header, .slices = std::make_unique<CubeSlices>(path, begin, header)};
}

}  // namespace multitetra

#include "server/volume/formats/netcdf3_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/axis_coordinates.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/netcdf3_header.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

bool is_volume(const NetcdfVariable& variable, const NetcdfHeader& header) {
  const std::vector<std::uint64_t> shape = header.shape(variable);
  return netcdf_type(variable.type) &&
         std::count_if(shape.begin(), shape.end(), [](std::uint64_t n) { return n > 1; }) >= 2;
}

const NetcdfVariable& chosen_variable(const fs::path& path, const NetcdfHeader& header,
                                      const VolumeChoice& choice) {
  const std::string wanted = choice.array.starts_with('/') ? choice.array.substr(1) : choice.array;
  const NetcdfVariable* largest = nullptr;
  double most = 0;
  std::string names;
  int count = 0;
  for (const NetcdfVariable& variable : header.variables) {
    if (!wanted.empty() && variable.name == wanted && netcdf_type(variable.type)) return variable;
    if (!is_volume(variable, header)) continue;
    double samples = 1;
    for (const std::uint64_t length : header.shape(variable))
      samples *= static_cast<double>(length);
    if (largest == nullptr || samples > most) {
      largest = &variable;
      most = samples;
    }
    ++count;
    if (names.size() < 600) names += (names.empty() ? "" : ", ") + variable.name;
  }
  if (wanted.empty() && largest != nullptr && (count == 1 || choice.first)) return *largest;
  fail_reading(path,
               wanted.empty() && count == 0
                   ? "it has no variable of numbers with two or more dimensions"
                   : (wanted.empty() ? "it has " + std::to_string(count) + " variables: "
                                     : "it has no variable '" + wanted + "'; there are ") +
                         names,
               "Give one, as in '" + path.filename().string() + ":/name'");
}

// The slices of a variable, whose records may be interleaved with others.
class NetcdfSlices : public StoredSlices {
 public:
  NetcdfSlices(const fs::path& file, std::uint64_t begin, std::uint64_t step,
               const ImageHeader& header)
      : file_(file), begin_(begin), step_(step), header_(header) {
    const std::uint64_t end =
        begin + step * static_cast<std::uint64_t>(header.dims[2] - 1) + header.slice_bytes();
    if (end <= file_.size()) return;
    fail_damaged(file, "it ends too early: its header declares " + std::to_string(end) +
                           " bytes, but it has " + std::to_string(file_.size()) + " bytes");
  }

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = first; i < first + count; ++i, into += header_.slice_bytes()) {
      const std::span<std::byte> slice(into, header_.slice_bytes());
      file_.read(begin_ + i * step_, slice);
      to_host_order(slice, bytes_of(header_.type), Endian::kBig);
    }
  }

 private:
  InputFile file_;
  std::uint64_t begin_;
  std::uint64_t step_;  // Distance between slices in bytes.
  ImageHeader header_;
};

std::string units_of(const NetcdfVariable& variable) {
  const NetcdfAttribute* const units = variable.attribute("units");
  return units == nullptr ? std::string() : units->text;
}

// Returns the coordinate variable of a dimension; none if there is none.
AxisCoordinates coordinates_of(const InputFile& file, const NetcdfHeader& header,
                               std::size_t dimension) {
  const auto& [name, length] = header.dimensions[dimension];
  for (const NetcdfVariable& variable : header.variables) {
    const auto type = netcdf_type(variable.type);
    if (variable.name != name || variable.dimensions != std::vector{dimension} || !type ||
        length > static_cast<std::uint64_t>(kMaxSide))
      continue;
    const std::size_t width = bytes_of(*type);
    AxisCoordinates coordinates;
    coordinates.unit = units_of(variable);
    std::vector<std::byte> one(width);
    for (std::uint64_t i = 0; i < length; ++i) {
      const std::uint64_t step = variable.has_records ? header.record_bytes : width;
      file.read(variable.begin + i * step, one);
      to_host_order(one, width, Endian::kBig);
      coordinates.values.push_back(number_from(*type, one.data()));
    }
    return coordinates;
  }
  return {};
}

void place_variable(const InputFile& file, const NetcdfHeader& netcdf,
                    const NetcdfVariable& variable, StoredVolume& volume) {
  const std::size_t rank = variable.dimensions.size();
  const std::size_t axes = std::min<std::size_t>(rank, 3);
  std::array<AxisCoordinates, 3> coordinates;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    coordinates[axis] = coordinates_of(file, netcdf, variable.dimensions[rank - 1 - axis]);
  }
  place_by_coordinates(file.path(), coordinates, axes, volume.header, volume.notices);
}

std::optional<double> number_of(const NetcdfVariable& variable, std::string_view name) {
  const NetcdfAttribute* const attribute = variable.attribute(name);
  if (attribute == nullptr || attribute->numbers.size() != 1) return std::nullopt;
  return attribute->numbers[0];
}

// Returns the number of samples along x, y and z.
std::array<std::int64_t, 3> sides_of(const fs::path& path, const NetcdfVariable& variable,
                                     const std::vector<std::uint64_t>& shape) {
  const std::size_t rank = shape.size();
  if (rank < 2 || rank > 5) {
    fail_reading(path,
                 "its variable '" + variable.name + "' has " + std::to_string(rank) + " dimensions",
                 "Choose a variable with 2 to 5");
  }
  std::array<std::int64_t, 3> sides = {1, 1, 1};
  for (std::size_t axis = 0; axis < std::min<std::size_t>(rank, 3); ++axis) {
    const std::uint64_t length = shape[rank - 1 - axis];
    if (length > static_cast<std::uint64_t>(kMaxSide)) {
      fail_reading(path,
                   "a side of its variable '" + variable.name + "' has " + std::to_string(length) +
                       " samples",
                   "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
    }
    sides[axis] = static_cast<std::int64_t>(length);
  }
  return sides;
}

void set_values(const NetcdfVariable& variable, ImageHeader& header) {
  header.meaning.value_unit = unit_from(units_of(variable));
  header.slope = number_of(variable, "scale_factor").value_or(1);
  header.intercept = number_of(variable, "add_offset").value_or(0);
  for (const char* name : {"_FillValue", "missing_value"}) {
    if (const auto number = number_of(variable, name)) header.missing.push_back(*number);
  }
}

// Returns the distance in bytes between the entries of each dimension.
std::vector<std::uint64_t> strides_of(const fs::path& path, const NetcdfHeader& netcdf,
                                      const NetcdfVariable& variable,
                                      const std::vector<std::uint64_t>& shape,
                                      std::size_t sample_bytes) {
  const std::size_t rank = shape.size();
  std::vector<std::uint64_t> strides(rank, sample_bytes);
  for (std::size_t d = rank - 1; d-- > 0;) strides[d] = strides[d + 1] * shape[d + 1];
  if (variable.has_records) strides[0] = netcdf.record_bytes;
  // Rows that are records are not contiguous.
  if (rank == 2 && variable.has_records && strides[0] != shape[1] * strides[1]) {
    fail_reading(path, "its variable '" + variable.name + "' has one line for each record",
                 "Copy it into a file with fixed dimensions");
  }
  return strides;
}

// Chooses an entry of a dimension before the volume's three: the first is the time, the second the
// channel. Notes their number in the volume.
std::int64_t entry_of(const fs::path& path, std::size_t dimension, const std::string& name,
                      std::uint64_t length, const VolumeChoice& choice, StoredVolume& volume) {
  const bool is_channel = dimension > 0;
  const auto count = static_cast<std::int64_t>(length);
  if (is_channel) {
    volume.channels = count;
  } else {
    volume.contents.times.count = count;
  }
  const FileEntries entries = {
      .count = count,
      .several = "its dimension " + name + " has " + std::to_string(length) + " entries",
      .remedy =
          std::string("Choose one with ") + (is_channel ? "--channel" : "--time") + ", from 0",
      .missing = "its dimension " + name + " has no entry"};
  return chosen_entry(path, entries, is_channel ? choice.channel : choice.time, choice.first);
}

}  // namespace

bool is_netcdf3(std::string_view beginning) {
  return beginning.size() >= 4 && beginning.starts_with("CDF") &&
         (beginning[3] == 1 || beginning[3] == 2 || beginning[3] == 5);
}

StoredVolume open_netcdf3(const fs::path& path, const VolumeChoice& choice) {
  const InputFile file(path);
  if (!is_netcdf3(file.beginning(4))) {
    fail_damaged(path, "it is not a NetCDF file");
  }
  const NetcdfHeader netcdf = read_netcdf_header(file);
  const NetcdfVariable& variable = chosen_variable(path, netcdf, choice);
  const std::vector<std::uint64_t> shape = netcdf.shape(variable);
  const std::size_t rank = shape.size();
  StoredVolume volume{.header = {.type = *netcdf_type(variable.type)}, .slices = nullptr};
  ImageHeader& header = volume.header;
  header.dims = sides_of(path, variable, shape);
  place_variable(file, netcdf, variable, volume);
  set_values(variable, header);
  check_header(path, header);

  const std::vector<std::uint64_t> strides =
      strides_of(path, netcdf, variable, shape, bytes_of(header.type));
  std::uint64_t begin = variable.begin;
  for (std::size_t d = 0; d + 3 < rank; ++d) {
    const std::string& name = netcdf.dimensions[variable.dimensions[d]].first;
    begin +=
        strides[d] * static_cast<std::uint64_t>(entry_of(path, d, name, shape[d], choice, volume));
  }
  const std::uint64_t step = rank >= 3 ? strides[rank - 3] : header.slice_bytes();
  volume.slices = std::make_unique<NetcdfSlices>(path, begin, step, header);
  return volume;
}

}  // namespace multitetra

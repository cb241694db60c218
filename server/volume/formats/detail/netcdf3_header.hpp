// The header of a NetCDF-3 file: the names, types and locations of its variables.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/image/stored_type.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {

struct NetcdfAttribute {
  std::string name;
  std::string text = {};             // Value of a text attribute.
  std::vector<double> numbers = {};  // Value of a numeric attribute.
};

struct NetcdfVariable {
  std::string name;
  std::vector<std::size_t> dimensions = {};
  std::vector<NetcdfAttribute> attributes = {};
  int type = 0;
  std::uint64_t begin = 0;
  // The first dimension is unlimited: entries are one record apart.
  bool has_records = false;

  [[nodiscard]] const NetcdfAttribute* attribute(std::string_view wanted) const {
    const auto found = std::find_if(attributes.begin(), attributes.end(),
                                    [&](const auto& entry) { return entry.name == wanted; });
    return found == attributes.end() ? nullptr : &*found;
  }
};

struct NetcdfHeader {
  std::vector<std::pair<std::string, std::uint64_t>> dimensions;
  std::vector<NetcdfVariable> variables;
  std::uint64_t record_bytes = 0;

  [[nodiscard]] std::vector<std::uint64_t> shape(const NetcdfVariable& variable) const {
    std::vector<std::uint64_t> lengths;
    for (const std::size_t d : variable.dimensions) lengths.push_back(dimensions[d].second);
    return lengths;
  }
};

// Returns nullopt for characters and invalid codes.
[[nodiscard]] std::optional<StoredType> netcdf_type(int code);

// Requires is_netcdf3(). Throws VolumeFileError if the header is damaged or truncated.
[[nodiscard]] NetcdfHeader read_netcdf_header(const InputFile& file);

}  // namespace multitetra

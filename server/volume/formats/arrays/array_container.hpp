// Arrays with attributes, addressed by paths, as HDF5, NetCDF and Zarr hold them: all that the
// conventions of conventions.hpp read of a file. Everything returned comes from an untrusted file.
// A container without groups, attributes or coordinates inherits that there are none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/image/stored_type.hpp"

namespace multitetra {

class ArrayContainer {
 public:
  virtual ~ArrayContainer() = default;

  // A file that led to this one and describes its arrays, as BigDataViewer has it; else empty.
  std::filesystem::path described_by = {};

  // The file or folder, for sentences and for files beside it.
  [[nodiscard]] virtual std::filesystem::path file() const = 0;
  // Paths of the arrays of numbers with two or more sides of more than one sample.
  [[nodiscard]] virtual std::vector<std::string> arrays() const = 0;
  // Names inside a group, sorted; none if there is no such group.
  [[nodiscard]] virtual std::vector<std::string> children(const std::string&) const { return {}; }
  // The sides of an array, slowest first; none if there is no such array of numbers.
  [[nodiscard]] virtual std::vector<std::int64_t> shape(const std::string& array) const = 0;
  // The type of an array with a shape; after shape() has found one.
  [[nodiscard]] virtual std::optional<StoredType> type(const std::string& array) const = 0;
  // All numbers of an array; none if there is no such array, or if it has more than kMaxValues.
  [[nodiscard]] virtual std::vector<double> values(const std::string&) const { return {}; }
  // The numbers or texts of an attribute of a group or an array; none if there is no such
  // attribute.
  [[nodiscard]] virtual std::vector<double> numbers(const std::string&, const char*) const {
    return {};
  }
  // Whether an attribute is known to be stored as floats.
  [[nodiscard]] virtual bool has_floats(const std::string&, const char*) const { return false; }
  [[nodiscard]] virtual std::vector<std::string> texts(const std::string&, const char*) const {
    return {};
  }
  // A name for each dimension of an array, empty where it has none.
  [[nodiscard]] virtual std::vector<std::string> dimension_names(const std::string&) const {
    return {};
  }
  // The array with the coordinates along a dimension; empty if there is none.
  [[nodiscard]] virtual std::string coordinates(const std::string&, std::size_t) const {
    return {};
  }

  // The first text, or the first number; empty or `otherwise` if there is none.
  [[nodiscard]] std::string text(const std::string& object, const char* attribute) const {
    const std::vector<std::string> all = texts(object, attribute);
    return all.empty() ? std::string() : all.front();
  }
  [[nodiscard]] double number(const std::string& object, const char* attribute,
                              double otherwise) const {
    const std::vector<double> all = numbers(object, attribute);
    return all.empty() ? otherwise : all.front();
  }

  static constexpr std::size_t kMaxValues = std::size_t{1} << 16;
};

// "/entry/data/d" -> "/entry/data"; "" for the root's children.
[[nodiscard]] inline std::string group_of(const std::string& path) {
  return path.substr(0, path.find_last_of('/') == std::string::npos ? 0 : path.find_last_of('/'));
}

}  // namespace multitetra

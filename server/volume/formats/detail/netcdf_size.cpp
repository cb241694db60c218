#include "server/volume/formats/detail/netcdf_size.hpp"

#include <netcdf.h>

#include <array>
#include <string_view>
#include <utility>

namespace multitetra {

std::optional<StoredType> netcdf_type(int type) {
  constexpr std::array<std::pair<nc_type, StoredType>, 10> kTypes = {
      {{NC_BYTE, StoredType::kI8},
       {NC_UBYTE, StoredType::kU8},
       {NC_SHORT, StoredType::kI16},
       {NC_USHORT, StoredType::kU16},
       {NC_INT, StoredType::kI32},
       {NC_UINT, StoredType::kU32},
       {NC_INT64, StoredType::kI64},
       {NC_UINT64, StoredType::kU64},
       {NC_FLOAT, StoredType::kF32},
       {NC_DOUBLE, StoredType::kF64}}};
  for (const auto& [known, stored] : kTypes) {
    if (known == type) return stored;
  }
  return std::nullopt;
}

namespace {

class ClassicSize {
 public:
  ClassicSize(int id, int format) : id_(id), wide_(format == NC_FORMAT_64BIT_DATA ? 8 : 4) {
    const std::uint64_t offset = format == NC_FORMAT_CLASSIC ? 4 : 8;
    int dimensions = 0;
    int variables = 0;
    int unlimited = -1;
    nc_inq(id_, &dimensions, &variables, nullptr, &unlimited);
    bytes_ = 4 + wide_ + 3 * (4 + wide_);
    for (int d = 0; d < dimensions; ++d) {
      std::array<char, NC_MAX_NAME + 1> name{};
      nc_inq_dimname(id_, d, name.data());
      bytes_ += named(name.data()) + wide_;
    }
    add_attributes(NC_GLOBAL);
    std::size_t records = 0;
    if (unlimited >= 0) nc_inq_dimlen(id_, unlimited, &records);
    std::uint64_t record = 0;
    std::uint64_t plain_record = 0;
    int record_variables = 0;
    for (int v = 0; v < variables; ++v) {
      std::array<char, NC_MAX_NAME + 1> name{};
      std::array<int, NC_MAX_VAR_DIMS> ids{};
      nc_type type = NC_NAT;
      int rank = 0;
      nc_inq_var(id_, v, name.data(), &type, &rank, ids.data(), nullptr);
      bytes_ += named(name.data()) + wide_ + static_cast<std::uint64_t>(rank) * wide_ + 4 + wide_ +
                offset + 4 + wide_;
      add_attributes(v);
      std::uint64_t size = bytes_of_type(type);
      const bool has_records = rank > 0 && ids[0] == unlimited;
      for (int d = has_records ? 1 : 0; d < rank; ++d) {
        std::size_t length = 0;
        nc_inq_dimlen(id_, ids[static_cast<std::size_t>(d)], &length);
        size *= length;
      }
      (has_records ? record : bytes_) += padded(size);
      if (has_records) plain_record = size;
      record_variables += has_records;
    }
    // A single variable with records has no gaps between them.
    bytes_ += records * (record_variables == 1 ? plain_record : record);
  }

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  static std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }
  [[nodiscard]] std::uint64_t named(std::string_view name) const {
    return wide_ + padded(name.size());
  }
  static std::uint64_t bytes_of_type(nc_type type) {
    const std::optional<StoredType> stored = netcdf_type(type);
    return stored ? multitetra::bytes_of(*stored) : 1;
  }
  void add_attributes(int variable) {
    int count = 0;
    nc_inq_varnatts(id_, variable, &count);
    for (int i = 0; i < count; ++i) {
      std::array<char, NC_MAX_NAME + 1> name{};
      nc_type type = NC_NAT;
      std::size_t length = 0;
      nc_inq_attname(id_, variable, i, name.data());
      nc_inq_att(id_, variable, name.data(), &type, &length);
      bytes_ += named(name.data()) + 4 + wide_ + padded(length * bytes_of_type(type));
    }
  }

  int id_;
  std::uint64_t wide_;  // Bytes of a count.
  std::uint64_t bytes_ = 0;
};

}  // namespace

std::uint64_t least_classic_bytes(int id, int format) { return ClassicSize(id, format).bytes(); }

}  // namespace multitetra

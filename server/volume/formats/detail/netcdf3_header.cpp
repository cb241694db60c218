#include "server/volume/formats/detail/netcdf3_header.hpp"

#include <array>
#include <cstring>
#include <span>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxNetcdfHeaderBytes = std::size_t{1} << 24;
constexpr std::uint64_t kMaxEntries = 100'000;

class NetcdfParser {
 public:
  explicit NetcdfParser(const InputFile& file)
      : file_(file), bytes_(file.beginning(kMaxNetcdfHeaderBytes)), at_(4) {
    version_ = static_cast<unsigned char>(bytes_[3]);
  }

  NetcdfHeader parse() {
    NetcdfHeader header;
    std::uint64_t records = count();
    for (std::uint64_t i = list(10); i > 0; --i) {
      std::string name = text();
      header.dimensions.emplace_back(std::move(name), count());
    }
    (void)attributes();
    for (std::uint64_t i = list(11); i > 0; --i) header.variables.push_back(variable(header));
    std::uint64_t record_variables = 0;
    // Size of a record without padding.
    std::uint64_t exact = 0;
    for (const NetcdfVariable& entry : header.variables) {
      if (!entry.has_records) continue;
      std::uint64_t bytes = entry.type == 2 ? 1 : type_bytes(entry.type);
      for (std::size_t d = 1; d < entry.dimensions.size(); ++d) {
        const std::uint64_t length = header.dimensions[entry.dimensions[d]].second;
        if (length > 0 && bytes > (std::uint64_t{1} << 50) / length) damaged();
        bytes *= length;
      }
      ++record_variables;
      exact = bytes;
      header.record_bytes += (bytes + 3) / 4 * 4;
    }
    if (record_variables == 1) header.record_bytes = exact;
    // "Streaming": the count was never written and follows from the length of the file.
    const bool is_streaming = records == (version_ == 5 ? ~std::uint64_t{0} : 0xFFFFFFFF);
    if (is_streaming) {
      std::uint64_t first = file_.size();
      for (const NetcdfVariable& entry : header.variables) {
        if (entry.has_records) first = std::min(first, entry.begin);
      }
      records = header.record_bytes == 0 ? 0 : (file_.size() - first) / header.record_bytes;
    }
    for (auto& [name, length] : header.dimensions) {
      if (length == 0) length = records;
    }
    return header;
  }

 private:
  [[noreturn]] void damaged() const {
    fail_damaged(file_.path(), "its NetCDF header is damaged or truncated");
  }

  static std::uint64_t type_bytes(int code) {
    const auto type = netcdf_type(code);
    return type ? bytes_of(*type) : 1;
  }

  template <typename Number>
  Number take() {
    if (bytes_.size() - at_ < sizeof(Number)) damaged();
    Number number;
    std::memcpy(&number, bytes_.data() + at_, sizeof(number));
    to_host_order(std::as_writable_bytes(std::span(&number, 1)), sizeof(number), Endian::kBig);
    at_ += sizeof(number);
    return number;
  }
  std::uint64_t count() { return version_ == 5 ? take<std::uint64_t>() : take<std::uint32_t>(); }
  std::uint64_t offset() { return version_ == 1 ? take<std::uint32_t>() : take<std::uint64_t>(); }

  std::string text() {
    const std::uint64_t length = count();
    if (length > bytes_.size() - at_) damaged();
    std::string result = bytes_.substr(at_, length);
    skip((length + 3) / 4 * 4);
    return result;
  }
  void skip(std::uint64_t bytes) {
    if (bytes > bytes_.size() - at_) damaged();
    at_ += bytes;
  }

  // Returns the length of a list of dimensions (10), variables (11) or attributes (12).
  std::uint64_t list(std::uint32_t expected) {
    const auto tag = take<std::uint32_t>();
    const std::uint64_t length = count();
    if (length > kMaxEntries || (length > 0 && tag != expected)) damaged();
    return length;
  }

  std::vector<NetcdfAttribute> attributes() {
    std::vector<NetcdfAttribute> result;
    for (std::uint64_t i = list(12); i > 0; --i) {
      NetcdfAttribute& attribute = result.emplace_back(NetcdfAttribute{.name = text()});
      const int type = static_cast<int>(take<std::uint32_t>());
      const std::uint64_t length = count();
      const std::uint64_t width = type_bytes(type);
      if (length > bytes_.size()) damaged();
      const std::size_t begin = at_;
      skip((length * width + 3) / 4 * 4);
      if (type == 2) {
        attribute.text = bytes_.substr(begin, length);
        attribute.text.resize(std::min(attribute.text.find('\0'), attribute.text.size()));
      } else if (const auto known = netcdf_type(type)) {
        std::string raw = bytes_.substr(begin, std::min<std::uint64_t>(length, 16) * width);
        const std::span<std::byte> numbers = std::as_writable_bytes(std::span(raw));
        to_host_order(numbers, width, Endian::kBig);
        for (std::size_t at = 0; at < raw.size(); at += width) {
          attribute.numbers.push_back(number_from(*known, numbers.data() + at));
        }
      }
    }
    return result;
  }

  NetcdfVariable variable(const NetcdfHeader& header) {
    NetcdfVariable result{.name = text()};
    const std::uint64_t dimensions = count();
    if (dimensions > 1024) damaged();
    for (std::uint64_t d = 0; d < dimensions; ++d) {
      const std::uint64_t dimension = count();
      if (dimension >= header.dimensions.size()) damaged();
      result.dimensions.push_back(dimension);
      if (header.dimensions[dimension].second != 0) continue;
      if (d > 0) damaged();  // Only the first one may be unlimited.
      result.has_records = true;
    }
    result.attributes = attributes();
    result.type = static_cast<int>(take<std::uint32_t>());
    (void)count();  // The size, which is wrong for large variables.
    result.begin = offset();
    return result;
  }

  const InputFile& file_;
  std::string bytes_;
  std::size_t at_;
  int version_ = 1;
};

}  // namespace

std::optional<StoredType> netcdf_type(int code) {
  constexpr std::array<std::optional<StoredType>, 12> kTypes = {
      std::nullopt,     StoredType::kI8,  std::nullopt,     StoredType::kI16,
      StoredType::kI32, StoredType::kF32, StoredType::kF64, StoredType::kU8,
      StoredType::kU16, StoredType::kU32, StoredType::kI64, StoredType::kU64};
  return code > 0 && code < static_cast<int>(kTypes.size()) ? kTypes[static_cast<std::size_t>(code)]
                                                            : std::nullopt;
}

NetcdfHeader read_netcdf_header(const InputFile& file) { return NetcdfParser(file).parse(); }

}  // namespace multitetra

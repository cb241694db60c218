#include "server/volume/formats/zarr/detail/chunked_array.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"
#include "server/volume/formats/zarr/detail/zarr_json.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxDimensions = 8;
constexpr std::int64_t kMaxLength = std::int64_t{1} << 40;
constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMaxChunksPerShard = std::uint64_t{1} << 20;

// Thrown while parsing metadata; the functions below convert it to a Result.
struct Refused {
  Error error;
};

[[noreturn]] void refuse(const std::string& what) {
  throw Refused{{ErrorCode::kInvalidArgument, what}};
}

std::string shown(const Json& value) {
  std::string text = json_text(value);
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

const Json& member(const Json& object, const char* key) {
  if (!object.is_object() || !object.contains(key)) {
    refuse(std::string("its metadata do not have a field \"") + key + "\"");
  }
  return object.at(key);
}

std::vector<std::int64_t> lengths_of(const Json& object, const char* key, std::int64_t least) {
  const Json& list = member(object, key);
  std::vector<std::int64_t> lengths;
  if (!list.is_array() || list.empty() || list.size() > kMaxDimensions) {
    refuse(std::string("its \"") + key + "\" is not a list of 1 to 8 lengths: " + shown(list));
  }
  for (const Json& length : list) {
    if (!length.is_number_integer() || length.is_number_float() || length < least ||
        length > kMaxLength) {
      refuse(std::string("its \"") + key + "\" has an invalid length: " + shown(length));
    }
    lengths.push_back(length.get<std::int64_t>());
  }
  return lengths;
}

std::uint64_t product_of(const std::vector<std::int64_t>& lengths, std::uint64_t most,
                         const char* what) {
  std::uint64_t product = 1;
  for (const std::int64_t length : lengths) {
    const auto factor = static_cast<std::uint64_t>(length);
    if (product > most / factor) refuse(std::string("its ") + what + " are too large");
    product *= factor;
  }
  return product;
}

template <typename Number>
void put_number(std::vector<std::byte>& into, Number number) {
  into.resize(sizeof(number));
  std::memcpy(into.data(), &number, sizeof(number));
}

// The bits of a number in hexadecimal, "0x7fc00000"; none for other values.
template <typename Number>
std::optional<Number> number_of_bits(const Json& value) {
  const std::string text = value.is_string() ? value.get<std::string>() : std::string();
  if (!text.starts_with("0x") || text.size() != 2 + 2 * sizeof(Number)) return std::nullopt;
  const auto bits = parse_number<std::uint64_t>(std::string_view(text).substr(2), 16);
  if (!bits) return std::nullopt;
  Number number;
  std::memcpy(&number, &*bits, sizeof number);  // Requires a little-endian host.
  return number;
}

template <typename Number>
void put_json_number(std::vector<std::byte>& into, const Json& value) {
  if (const auto number = number_of_bits<Number>(value)) return put_number(into, *number);
  if constexpr (std::is_floating_point_v<Number>) {
    if (value == "NaN") return put_number(into, std::numeric_limits<Number>::quiet_NaN());
    if (value == "Infinity") return put_number(into, std::numeric_limits<Number>::infinity());
    if (value == "-Infinity") return put_number(into, -std::numeric_limits<Number>::infinity());
    if (value.is_number()) return put_number(into, value.get<Number>());
  } else {
    if (value.is_boolean()) return put_number(into, static_cast<Number>(value.get<bool>()));
    if (value.is_number_unsigned() && std::in_range<Number>(value.get<std::uint64_t>())) {
      return put_number(into, static_cast<Number>(value.get<std::uint64_t>()));
    }
    if (value.is_number_integer() && !value.is_number_unsigned() &&
        std::in_range<Number>(value.get<std::int64_t>())) {
      return put_number(into, static_cast<Number>(value.get<std::int64_t>()));
    }
    if (value.is_number_float() && value.get<double>() == 0) return put_number(into, Number{0});
  }
  refuse("its fill value " + shown(value) + " is not a value of its type");
}

std::vector<std::byte> fill_of(StoredType type, const Json& value) {
  std::vector<std::byte> fill(bytes_of(type));
  if (value.is_null()) return fill;
  with_number_type(type, [&]<typename Number>() { put_json_number<Number>(fill, value); });
  return fill;
}

constexpr std::string_view kHalf3 = "float16";
constexpr std::string_view kHalf2 = "f2";

// Parses the names that Zarr 3 and N5 share. "bool" is a byte; halves become floats.
StoredType long_type(const Json& value) {
  const std::string word = value.is_string() ? value.get<std::string>() : std::string();
  if (word == "bool") return StoredType::kU8;
  if (word == kHalf3) return StoredType::kF32;
  const auto type = stored_type_from_word(word);
  if (type && word.find_first_of("1368") != std::string::npos) return *type;
  refuse("its samples are of type " + shown(value) +
         "; supported are integers of 8 to 64 bits and floats of 16 to 64");
}

// Parses "<i2": byte order, kind of number, number of bytes.
void set_type_2(ArrayLayout& layout, const Json& value) {
  const std::string word = value.is_string() ? value.get<std::string>() : std::string();
  if (word.size() == 3 && word[2] >= '1' && word[2] <= '8') {
    const bool are_halves = word.substr(1) == kHalf2;
    const std::string kind(1, word[1] == 'b' && word[2] == '1' ? 'u' : word[1]);
    const auto type = are_halves ? std::optional(StoredType::kF32)
                                 : stored_type_from(kind + std::to_string(8 * (word[2] - '0')));
    if (type && (word[0] == '<' || word[0] == '>' || (word[0] == '|' && bytes_of(*type) == 1))) {
      layout.type = *type;
      layout.are_halves = are_halves;
      layout.endian = word[0] == '>' ? Endian::kBig : Endian::kLittle;
      return;
    }
  }
  refuse("its samples are of type " + shown(value) +
         "; supported are integers of 8 to 64 bits and floats of 16 to 64");
}

Packing packing_of(const Json& value) {
  const auto packing =
      value.is_string() ? packing_from(value.get<std::string>()) : std::optional<Packing>();
  if (packing) return *packing;
  refuse("its chunks are compressed with " + shown(value) +
         "; supported are blosc, lz4, zstd, gzip, zlib, bz2 and none");
}

void add_packing(ArrayLayout& layout, Packing packing) {
  if (packing != Packing::kNone) layout.codecs.push_back({.packing = packing});
}

void check_sizes(const ArrayLayout& layout) {
  if (layout.chunk.size() != layout.shape.size()) {
    refuse("its chunks have " + std::to_string(layout.chunk.size()) +
           " dimensions, but the array has " + std::to_string(layout.shape.size()));
  }
  (void)product_of(layout.chunk, kMaxChunkBytes / bytes_of(layout.type), "chunks");
}

std::vector<std::size_t> straight(std::size_t dimensions) {
  std::vector<std::size_t> order(dimensions);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

// ---- Zarr 3

struct Codecs {
  std::vector<ChunkCodec> after_reading = {};  // In order of decoding, the reverse of writing.
  const Json* shards = nullptr;
  std::optional<Endian> endian = std::nullopt;
  std::vector<std::size_t> order = {};
};

const Json& configuration_of(const Json& codec) {
  static const Json kEmpty = Json::object();
  return codec.contains("configuration") ? codec.at("configuration") : kEmpty;
}

Codecs codecs_of(const Json& list, std::size_t dimensions) {
  Codecs codecs{.order = straight(dimensions)};
  if (!list.is_array() || list.size() > 16) refuse("its \"codecs\" are not a list: " + shown(list));
  for (const Json& codec : list) {
    const Json& name = member(codec, "name");
    const Json& configuration = configuration_of(codec);
    if (name == "bytes") {
      codecs.endian = configuration.value("endian", std::string("little")) == "big"
                          ? Endian::kBig
                          : Endian::kLittle;
    } else if (name == "transpose") {
      const std::vector<std::int64_t> order = lengths_of(configuration, "order", 0);
      std::vector<std::size_t> after(codecs.order.size());
      std::vector<bool> seen(codecs.order.size());
      if (order.size() != after.size())
        refuse("the number of dimensions of its transpose differs from the array's");
      for (std::size_t i = 0; i < order.size(); ++i) {
        const auto from = static_cast<std::size_t>(order[i]);
        if (from >= after.size() || seen[from])
          refuse("its transpose is not a permutation: " + shown(configuration));
        seen[from] = true;
        after[i] = codecs.order[from];
      }
      codecs.order = after;
    } else if (name == "sharding_indexed") {
      codecs.shards = &configuration;
    } else if (name == "crc32c") {
      codecs.after_reading.insert(codecs.after_reading.begin(),
                                  {.kind = ChunkCodec::Kind::kCheckCrc32c});
    } else {
      codecs.after_reading.insert(codecs.after_reading.begin(), {.packing = packing_of(name)});
    }
  }
  return codecs;
}

void set_shards(ArrayLayout& layout, const Json& configuration, const Codecs& outer) {
  if (!outer.after_reading.empty() || outer.order != straight(layout.shape.size())) {
    refuse("its shards are compressed as a whole, which is not supported");
  }
  const std::vector<std::int64_t> shard = layout.chunk;
  layout.chunk = lengths_of(configuration, "chunk_shape", 1);
  if (layout.chunk.size() != shard.size())
    refuse("the number of dimensions of its inner chunks differs from the array's");
  ShardLayout shards;
  for (std::size_t i = 0; i < shard.size(); ++i) {
    if (shard[i] % layout.chunk[i] != 0)
      refuse("the size of its shards is not a multiple of that of its chunks");
    shards.chunk_counts.push_back(shard[i] / layout.chunk[i]);
  }
  (void)product_of(shards.chunk_counts, kMaxChunksPerShard, "shards");
  const Codecs inner = codecs_of(member(configuration, "codecs"), shard.size());
  const Codecs index = codecs_of(member(configuration, "index_codecs"), shard.size() + 1);
  if (inner.shards != nullptr || index.shards != nullptr)
    refuse("it has shards within shards, which is not supported");
  for (const ChunkCodec& codec : index.after_reading) {
    if (codec.kind != ChunkCodec::Kind::kCheckCrc32c)
      refuse("the indices of its shards are compressed, which is not supported");
  }
  if (index.endian.value_or(Endian::kLittle) != Endian::kLittle) {
    refuse("the indices of its shards are big-endian, which is not supported");
  }
  shards.index_codecs = index.after_reading;
  shards.index_at_end = configuration.value("index_location", std::string("end")) != "start";
  layout.codecs = inner.after_reading;
  layout.endian = inner.endian.value_or(Endian::kLittle);
  layout.order = inner.order;
  layout.shards = shards;
}

void set_keys_3(ArrayLayout& layout, const Json& encoding) {
  const Json& name = member(encoding, "name");
  if (name != "default" && name != "v2")
    refuse("the encoding of its chunk keys is not supported: " + shown(name));
  const Json& configuration = configuration_of(encoding);
  const std::string separator = configuration.value("separator", name == "v2" ? "." : "/");
  if (separator != "." && separator != "/")
    refuse("the separator of its chunk keys is not / or .: '" + separator + "'");
  layout.key_separator = separator[0];
  layout.key_prefix = name == "v2" ? std::string() : "c" + separator;
}

ArrayLayout zarr_3(const Json& json) {
  if (member(json, "zarr_format") != 3 || member(json, "node_type") != "array") {
    refuse("it is not a Zarr 3 array");
  }
  ArrayLayout layout;
  layout.shape = lengths_of(json, "shape", 0);
  layout.type = long_type(member(json, "data_type"));
  layout.are_halves = json.at("data_type") == kHalf3;
  const Json& grid = member(json, "chunk_grid");
  if (member(grid, "name") != "regular")
    refuse("its chunk grid is not supported: " + shown(grid.at("name")));
  layout.chunk = lengths_of(configuration_of(grid), "chunk_shape", 1);
  layout.fill = fill_of(layout.type, member(json, "fill_value"));
  set_keys_3(layout, member(json, "chunk_key_encoding"));
  if (layout.chunk.size() != layout.shape.size())
    refuse("the number of dimensions of its chunks differs from the array's");
  const Codecs codecs = codecs_of(member(json, "codecs"), layout.shape.size());
  if (codecs.shards != nullptr) {
    set_shards(layout, *codecs.shards, codecs);
  } else {
    layout.codecs = codecs.after_reading;
    layout.endian = codecs.endian.value_or(Endian::kLittle);
    layout.order = codecs.order;
  }
  if (json.contains("dimension_names") && json.at("dimension_names").is_array() &&
      json.at("dimension_names").size() == layout.shape.size()) {
    for (const Json& name : json.at("dimension_names")) {
      layout.dimension_names.push_back(name.is_string() ? name.get<std::string>() : std::string());
    }
  }
  check_sizes(layout);
  return layout;
}

// ---- Zarr 2 and N5

ArrayLayout zarr_2(const Json& json) {
  if (member(json, "zarr_format") != 2) refuse("it is not a Zarr 2 array");
  ArrayLayout layout;
  layout.shape = lengths_of(json, "shape", 0);
  layout.chunk = lengths_of(json, "chunks", 1);
  set_type_2(layout, member(json, "dtype"));
  layout.fill = fill_of(layout.type, member(json, "fill_value"));
  const double fill = number_from(layout.type, layout.fill.data());
  layout.fill_is_missing = fill != 0 && !std::isnan(fill);
  layout.order = straight(layout.shape.size());
  if (member(json, "order") == "F") std::reverse(layout.order.begin(), layout.order.end());
  if (json.contains("filters") && !json.at("filters").is_null() && !json.at("filters").empty()) {
    refuse("its chunks use the filters " + shown(json.at("filters")) + ", which are not supported");
  }
  const Json& compressor = member(json, "compressor");
  if (!compressor.is_null()) add_packing(layout, packing_of(member(compressor, "id")));
  const std::string separator = json.value("dimension_separator", std::string("."));
  if (separator != "." && separator != "/")
    refuse("its dimension_separator is not / or .: '" + separator + "'");
  layout.key_separator = separator[0];
  check_sizes(layout);
  return layout;
}

ArrayLayout n5(const Json& json) {
  ArrayLayout layout;
  layout.shape = lengths_of(json, "dimensions", 0);
  layout.chunk = lengths_of(json, "blockSize", 1);
  std::reverse(layout.shape.begin(), layout.shape.end());  // N5 lists the fastest dimension first.
  std::reverse(layout.chunk.begin(), layout.chunk.end());
  layout.type = long_type(member(json, "dataType"));
  layout.are_halves = json.at("dataType") == kHalf3;
  layout.endian = Endian::kBig;
  layout.fill.resize(bytes_of(layout.type));
  layout.order = straight(layout.shape.size());
  layout.key_separator = '/';
  layout.key_is_reversed = true;
  layout.has_block_headers = true;
  if (json.contains("compression")) {
    const Json& compression = json.at("compression");
    const Packing packing = packing_of(member(compression, "type"));
    if (packing == Packing::kSizedLz4)
      refuse("its blocks are compressed with the lz4 of Java, which is not supported");
    const bool zlib = packing == Packing::kGzip && compression.value("useZlib", false);
    add_packing(layout, zlib ? Packing::kZlib : packing);
  } else {
    add_packing(layout, packing_of(json.value("compressionType", Json("raw"))));
  }
  check_sizes(layout);
  return layout;
}

template <typename Parse>
Result<ArrayLayout> parsed(std::string_view text, const Parse& parse) {
  try {
    const Json json = parse_zarr_json(text);
    if (!json.is_object())
      return fail(ErrorCode::kDamagedData, "its metadata are not a JSON object");
    return parse(json);
  } catch (const Refused& refused) {
    return tl::unexpected(refused.error);
  } catch (const Json::exception& problem) {  // A field has an unexpected type.
    return fail(ErrorCode::kDamagedData,
                std::string("its metadata are damaged: ") + problem.what());
  }
}

}  // namespace

std::size_t ArrayLayout::chunk_bytes() const {
  std::size_t bytes = bytes_of(type);
  for (const std::int64_t length : chunk) bytes *= static_cast<std::size_t>(length);
  return bytes;
}

std::string ArrayLayout::key(const std::vector<std::int64_t>& object) const {
  std::string text = key_prefix;
  for (std::size_t i = 0; i < object.size(); ++i) {
    if (i > 0) text += key_separator;
    text += std::to_string(object[key_is_reversed ? object.size() - 1 - i : i]);
  }
  return text;
}

Result<ArrayLayout> parse_zarr_2(std::string_view text) { return parsed(text, zarr_2); }
Result<ArrayLayout> parse_zarr_3(std::string_view text) { return parsed(text, zarr_3); }
Result<ArrayLayout> parse_n5(std::string_view text) { return parsed(text, n5); }

}  // namespace multitetra

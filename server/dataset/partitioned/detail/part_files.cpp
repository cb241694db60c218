#include "server/dataset/partitioned/detail/part_files.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/base/hex_text.hpp"
#include "common/base/json.hpp"
#include "server/core/framework/axes.hpp"
#include "server/dataset/partitioned/part_plan.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using PartJson = nlohmann::json;

constexpr const char* kRecordFormat = "multitetra-part";

template <typename Action>
auto with_disk(const Action& action) {
  try {
    return action();
  } catch (const std::system_error& error) {
    throw DatasetFileError(std::string(error.what()) + ".");
  }
}

const fs::path& in_new_folder(const fs::path& file) {
  with_disk([&] { return fs::create_directories(file.parent_path()); });
  return file;
}

PartJson json_of(const ArrayFacts& facts) {
  return {{"bytes", facts.bytes}, {"checksum", facts.checksum}};
}
PartJson json_of(GridPoint p) { return {p.x, p.y, p.z}; }

// Reads the fields of a record; keeps the first error.
class RecordReader {
 public:
  explicit RecordReader(const PartJson& json) : json_(json) {}

  [[nodiscard]] bool is_good() const { return is_good_; }
  std::uint64_t number(const PartJson& object, const char* key) {
    if (!object.is_object() || !object.contains(key) || !object.at(key).is_number_unsigned()) {
      is_good_ = false;
      return 0;
    }
    return object.at(key).get<std::uint64_t>();
  }
  std::uint64_t number(const char* key) { return number(json_, key); }
  ArrayFacts facts(const char* key) {
    if (!json_.contains(key)) {
      is_good_ = false;
      return {};
    }
    return {.bytes = number(json_.at(key), "bytes"), .checksum = number(json_.at(key), "checksum")};
  }
  GridPoint point(const char* key) {
    if (!json_.contains(key) || !json_.at(key).is_array() || json_.at(key).size() != 3) {
      is_good_ = false;
      return {};
    }
    return by_axis([&](int axis) {
      const PartJson& value = json_.at(key).at(static_cast<std::size_t>(axis));
      const bool is_coordinate =
          value.is_number_unsigned() && value.get<std::uint64_t>() <= 1u << 20;
      is_good_ = is_good_ && is_coordinate;
      return is_coordinate ? value.get<std::int32_t>() : 0;
    });
  }
  std::vector<std::byte> bytes(const char* key) {
    const bool is_text = json_.contains(key) && json_.at(key).is_string();
    auto bytes =
        is_text ? bytes_from_hex(json_.at(key).get_ref<const std::string&>()) : std::nullopt;
    if (!bytes) is_good_ = false;
    return std::move(bytes).value_or(std::vector<std::byte>());
  }

 private:
  const PartJson& json_;
  bool is_good_ = true;
};

// Returns whether the name is that of a part's file, of this plan or an earlier one: "3.bricks".
bool is_part_file(const fs::path& file) {
  constexpr std::array<std::string_view, 6> kSuffixes = {".bricks", ".index",  ".ranges",
                                                         ".coarse", ".curves", ".json"};
  const std::string stem = file.stem().string();
  return stem.find_first_not_of("0123456789") == std::string::npos &&
         std::find(kSuffixes.begin(), kSuffixes.end(), file.extension().string()) !=
             kSuffixes.end();
}

}  // namespace

std::string text_with_checksum(nlohmann::json& json) {
  const std::string text = json_text(json);
  json["checksum"] = checksum(std::as_bytes(std::span(text)));
  return json_text(json, 1) + "\n";
}

Result<nlohmann::json> json_with_checksum(std::string_view text, const char* format) {
  // Skips anything nested deeper than our records: it fails the checksum and may exhaust the stack.
  const auto is_shallow = [](int depth, PartJson::parse_event_t, PartJson&) { return depth <= 4; };
  PartJson json = PartJson::parse(text, is_shallow, /*allow_exceptions=*/false);
  const auto bad = [format](const char* what) {
    return fail(ErrorCode::kDamagedData, "It " + std::string(what) + " (" + format +
                                             ", version 1). Create it again with this program.");
  };
  if (!json.is_object() || !json.contains("format") || json.at("format") != format ||
      !json.contains("version") || json.at("version") != 1) {
    return bad("has the wrong format or version");
  }
  if (!json.contains("checksum")) return bad("has no checksum");
  const PartJson sum = json.at("checksum");
  json.erase("checksum");
  const std::string compact = json_text(json);
  if (sum != checksum(std::as_bytes(std::span(compact))))
    return bad("has a checksum that does not match");
  return json;
}

std::optional<std::string> small_text(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  const FileSource source(file);
  constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20;
  if (source.size() > kMaxBytes) throw DatasetFileError(file, "it is longer than 256 MiB.");
  std::string text(source.size(), '\0');
  source.read(0, std::as_writable_bytes(std::span(text)));
  return text;
}

void write_whole(const fs::path& file, std::string_view text) {
  in_new_folder(file);
  with_disk([&] {
    AtomicFile into(file);
    into.write_at(0, std::as_bytes(std::span(text)));
    into.commit(Durability::kMachineStop);
  });
}

ArrayWriter::ArrayWriter(const fs::path& file)
    : file_(with_disk([&] { return AtomicFile(in_new_folder(file)); })) {}

void ArrayWriter::add(std::span<const std::byte> bytes) {
  with_disk([&] { file_.write_at(bytes_, bytes); });
  sum_.add(bytes);
  bytes_ += bytes.size();
}

ArrayFacts ArrayWriter::finish() {
  with_disk([&] { file_.commit(Durability::kMachineStop); });
  return {.bytes = bytes_, .checksum = sum_.value()};
}

CurvesWriter::CurvesWriter(const fs::path& file)
    : file_(with_disk([&] { return AtomicFile(in_new_folder(file)); })) {}

std::uint64_t CurvesWriter::put(std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  with_disk([&] { file_.write_at(bytes_, bytes); });
  return std::exchange(bytes_, bytes_ + bytes.size());
}

void CurvesWriter::get(std::uint64_t offset, std::span<std::byte> into) const {
  with_disk([&] { file_.read_at(offset, into); });
}

ArrayFacts CurvesWriter::finish() {
  RunningChecksum sum;
  std::vector<std::byte> portion;
  for (std::uint64_t done = 0; done < bytes_; done += portion.size()) {
    portion.resize(std::min<std::uint64_t>(std::uint64_t{1} << 20, bytes_ - done));
    get(done, portion);
    sum.add(portion);
  }
  with_disk([&] { file_.commit(Durability::kMachineStop); });
  return {.bytes = bytes_, .checksum = sum.value()};
}

std::uint64_t CurvesReader::put(std::span<const std::byte>) {
  throw std::logic_error("Curves of a part cannot be inserted.");
}

void CurvesReader::get(std::uint64_t offset, std::span<std::byte> into) const {
  if (offset > source_.size() || into.size() > source_.size() - offset) {
    throw std::runtime_error("The curves of a part are shorter than its record states.");
  }
  source_.read(offset, into);
}

void check_array(const fs::path& file, const ArrayFacts& facts) {
  const FileSource source(file);
  RunningChecksum sum;
  std::vector<std::byte> portion;
  for (std::uint64_t done = 0; done < source.size(); done += portion.size()) {
    portion.resize(std::min<std::uint64_t>(std::uint64_t{1} << 20, source.size() - done));
    source.read(done, portion);
    sum.add(portion);
  }
  if (source.size() == facts.bytes && sum.value() == facts.checksum) return;
  throw DatasetFileError(file, "its checksum does not match. Prepare this part again.");
}

std::string record_text(const PartRecord& record) {
  PartJson json = {{"format", kRecordFormat},
                   {"version", 1},
                   {"plan", record.plan},
                   {"part", record.part},
                   {"bricks", json_of(record.bricks)},
                   {"index", json_of(record.index)},
                   {"ranges", json_of(record.ranges)},
                   {"coarse", json_of(record.coarse)},
                   {"curves", json_of(record.curves)},
                   {"cells_begin", json_of(record.cell_curves.cells.begin)},
                   {"cells_end", json_of(record.cell_curves.cells.end)},
                   {"tile", json_of(record.cell_curves.tile)},
                   {"places", hex_text(record.cell_curves.tile_ranges)}};
  return text_with_checksum(json);
}

Result<PartRecord> parse_record(std::string_view text) {
  const auto json = json_with_checksum(text, kRecordFormat);
  if (!json) return tl::unexpected(json.error());
  RecordReader reader(*json);
  PartRecord record{.plan = reader.number("plan"),
                    .part = static_cast<std::size_t>(reader.number("part")),
                    .bricks = reader.facts("bricks"),
                    .index = reader.facts("index"),
                    .ranges = reader.facts("ranges"),
                    .coarse = reader.facts("coarse"),
                    .curves = reader.facts("curves"),
                    .cell_curves = {.cells = {.begin = reader.point("cells_begin"),
                                              .end = reader.point("cells_end")},
                                    .tile = reader.point("tile"),
                                    .tile_ranges = reader.bytes("places")}};
  const GridPoint tile = record.cell_curves.tile;
  const bool has_tiles = std::min({tile.x, tile.y, tile.z}) >= 1;
  if (reader.is_good() && (has_tiles || record.cell_curves.tile_ranges.empty())) return record;
  return fail(ErrorCode::kDamagedData, "The record is damaged. Prepare this part again.");
}

fs::path part_file(const fs::path& dataset, std::size_t part, const char* suffix) {
  return parts_folder(dataset) / (std::to_string(part + 1) + suffix);
}

void remove_parts(const fs::path& dataset) {
  const fs::path folder = parts_folder(dataset);
  std::vector<fs::path> files = {plan_file(dataset)};
  std::error_code ignored;
  for (fs::directory_iterator at(folder, ignored), end; !ignored && at != end;
       at.increment(ignored)) {
    if (is_part_file(at->path()) && at->is_regular_file(ignored)) files.push_back(at->path());
  }
  for (const fs::path& file : files) fs::remove(file, ignored);
  fs::remove(folder, ignored);
}

}  // namespace multitetra

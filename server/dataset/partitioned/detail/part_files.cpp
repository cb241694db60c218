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
constexpr std::uint32_t kMaxCoordinate = 1u << 20;

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

PartJson json_of(GridPoint p) { return {p.x, p.y, p.z}; }

std::optional<GridPoint> point_from(const PartJson& json) {
  const auto p = json.get<std::array<std::uint32_t, 3>>();
  if (*std::max_element(p.begin(), p.end()) > kMaxCoordinate) return std::nullopt;
  return by_axis(
      [&](int axis) { return static_cast<std::int32_t>(p[static_cast<std::size_t>(axis)]); });
}

// Returns the checksum of an array that is read in portions.
template <typename Read>
std::uint64_t checksum_of(std::uint64_t bytes, const Read& read) {
  RunningChecksum sum;
  std::vector<std::byte> portion;
  for (std::uint64_t done = 0; done < bytes; done += portion.size()) {
    portion.resize(std::min<std::uint64_t>(std::uint64_t{1} << 20, bytes - done));
    read(done, portion);
    sum.add(portion);
  }
  return sum.value();
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ArrayFacts, bytes, checksum)

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
  const std::uint64_t sum = checksum_of(
      bytes_, [this](std::uint64_t offset, std::span<std::byte> into) { get(offset, into); });
  with_disk([&] { file_.commit(Durability::kMachineStop); });
  return {.bytes = bytes_, .checksum = sum};
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
  const auto read = [&](std::uint64_t offset, std::span<std::byte> into) {
    source.read(offset, into);
  };
  if (source.size() == facts.bytes && checksum_of(facts.bytes, read) == facts.checksum) return;
  throw DatasetFileError(file, "its checksum does not match. Prepare this part again.");
}

std::string record_text(const PartRecord& record) {
  PartJson json = {{"format", kRecordFormat},
                   {"version", 1},
                   {"plan", record.plan},
                   {"part", record.part},
                   {"bricks", record.bricks},
                   {"index", record.index},
                   {"ranges", record.ranges},
                   {"coarse", record.coarse},
                   {"curves", record.curves},
                   {"cells_begin", json_of(record.cell_curves.cells.begin)},
                   {"cells_end", json_of(record.cell_curves.cells.end)},
                   {"tile", json_of(record.cell_curves.tile)},
                   {"places", hex_text(record.cell_curves.tile_ranges)}};
  return text_with_checksum(json);
}

Result<PartRecord> parse_record(std::string_view text) {
  const auto json = json_with_checksum(text, kRecordFormat);
  if (!json) return tl::unexpected(json.error());
  const auto damaged = [] {
    return fail(ErrorCode::kDamagedData, "The record is damaged. Prepare this part again.");
  };
  try {
    const auto begin = point_from(json->at("cells_begin"));
    const auto end = point_from(json->at("cells_end"));
    const auto tile = point_from(json->at("tile"));
    auto places = bytes_from_hex(json->at("places").get_ref<const std::string&>());
    if (!begin || !end || !tile || !places) return damaged();
    if (std::min({tile->x, tile->y, tile->z}) < 1 && !places->empty()) return damaged();
    return PartRecord{.plan = json->at("plan"),
                      .part = json->at("part"),
                      .bricks = json->at("bricks"),
                      .index = json->at("index"),
                      .ranges = json->at("ranges"),
                      .coarse = json->at("coarse"),
                      .curves = json->at("curves"),
                      .cell_curves = {.cells = {.begin = *begin, .end = *end},
                                      .tile = *tile,
                                      .tile_ranges = *std::move(places)}};
  } catch (const PartJson::exception&) {
    return damaged();
  }
}

fs::path part_file(const fs::path& dataset, std::size_t part, std::string_view suffix) {
  return parts_folder(dataset) / (std::to_string(part + 1) + std::string(suffix));
}

bool is_part_file(const fs::path& file) {
  const std::string stem = file.stem().string();
  return stem.find_first_not_of("0123456789") == std::string::npos &&
         std::find(kPartSuffixes.begin(), kPartSuffixes.end(), file.extension().string()) !=
             kPartSuffixes.end();
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

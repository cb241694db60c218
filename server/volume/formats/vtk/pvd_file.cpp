#include "server/volume/formats/vtk/pvd_file.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/result.hpp"
#include "common/base/utf8.hpp"
#include "common/sandbox/packed.hpp"
#include "common/sandbox/sandbox.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/xml_document.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

inline auto fields(PvdEntry& entry) { return std::tie(entry.file, entry.time); }

Result<std::vector<PvdEntry>> parse_pvd(std::string_view text) {
  const Result<XmlElement> xml = parse_xml(text);
  if (!xml) return tl::unexpected(xml.error());
  std::vector<PvdEntry> entries;
  bool is_valid = xml->name == "VTKFile" && xml->attribute("type") == "Collection";
  for (const XmlElement* const element : xml->all("DataSet")) {
    const std::optional<double> time = parse_finite(element->attribute("timestep"));
    entries.push_back({.file = element->attribute("file"), .time = time.value_or(0)});
    is_valid = is_valid && time && !entries.back().file.empty();
  }
  if (entries.size() > kMaxSourceMembers) {
    return fail(ErrorCode::kLimitExceeded,
                "it has more than " + std::to_string(kMaxSourceMembers) + " files");
  }
  if (!is_valid || entries.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "it is not a Collection of files that each have a time step");
  }
  return entries;
}

std::optional<std::vector<PvdEntry>> pvd_entries_from(std::string_view answer) {
  std::vector<PvdEntry> entries;
  const bool is_whole = unpack_all(answer, entries) && entries.size() <= kMaxSourceMembers;
  const auto is_valid = [](const PvdEntry& one) {
    return !one.file.empty() && std::isfinite(one.time);
  };
  if (!is_whole || !std::all_of(entries.begin(), entries.end(), is_valid)) return std::nullopt;
  return entries;
}

bool is_pvd(const std::filesystem::path& path) { return path.extension() == ".pvd"; }

namespace {

const SandboxTask kReadPvd = answering("read .pvd", [](const std::string& path) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 24;
  const InputFile file(path);
  const Result<std::vector<PvdEntry>> entries = parse_pvd(file.beginning(kMaxBytes));
  if (!entries) {
    const bool is_long = entries.error().code == ErrorCode::kLimitExceeded;
    fail_reading(path, entries.error().text,
                 is_long ? "Save several files with fewer times" : "Save it again");
  }
  return packed_values(*entries);
});

// Reads the entries in a sandbox. Throws VolumeFileError.
std::vector<PvdEntry> entries_of(const std::filesystem::path& path) {
  try {
    const std::string answer = run_in_sandbox(kReadPvd, {.readable = {path}}, path.string());
    if (auto entries = pvd_entries_from(answer)) return *std::move(entries);
  } catch (const SandboxError& problem) {
    fail_reading(path, problem.what(), "Save it again");
  } catch (const std::runtime_error& problem) {
    throw VolumeFileError(printable(problem.what()));
  }
  fail_reading(path, "its reader does not answer as a reader does", "Save it again");
}

}  // namespace

std::vector<CollectedFile> files_of_pvd(const std::filesystem::path& path,
                                        bool allow_external_files) {
  std::vector<CollectedFile> files;
  for (const PvdEntry& entry : entries_of(path)) {
    files.push_back({named_data_file(path, entry.file, allow_external_files), entry.time});
  }
  std::stable_sort(files.begin(), files.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  const auto twice = std::adjacent_find(
      files.begin(), files.end(), [](const auto& a, const auto& b) { return a.time == b.time; });
  if (twice != files.end()) {
    fail_reading(path, "it has several files of time " + shortest_text(twice->time),
                 "Save one file for each time, such as a .pvti file of all parts");
  }
  return files;
}

}  // namespace multitetra

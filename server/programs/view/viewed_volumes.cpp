#include "server/programs/view/viewed_volumes.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <span>
#include <string_view>
#include <system_error>

#include "common/base/exit_codes.hpp"
#include "common/base/hex_text.hpp"
#include "common/base/natural_order.hpp"
#include "common/base/text.hpp"
#include "common/mesh/checksum.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/provenance.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"
#include "server/volume/formats/volume_formats.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"
#include "server/volume/volume_files.hpp"
#include "server/volume/volume_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// ---- time series

// "flow_0012.vti" -> "flow_#.vti"
std::string without_numbers(const std::string& name) {
  std::string pattern;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!is_digit(name[i])) {
      pattern += name[i];
    } else if (i == 0 || !is_digit(name[i - 1])) {
      pattern += '#';
    }
  }
  return pattern;
}

bool have_one_grid(const std::string& a, const std::string& b, const VolumeFileOptions& options) {
  const auto first = open_volume(a, options);
  const auto second = open_volume(b, options);
  return first->header().dims == second->header().dims &&
         first->header().index_to_world == second->header().index_to_world;
}

bool are_times(const std::vector<std::string>& volumes, const VolumeFileOptions& options) {
  if (volumes.size() < 2) return false;
  const std::string pattern = without_numbers(fs::path(volumes.front()).filename().string());
  const bool is_numbered = pattern.find('#') != std::string::npos;
  const auto is_alike = [&](const std::string& volume) {
    return fs::path(volume).parent_path() == fs::path(volumes.front()).parent_path() &&
           without_numbers(fs::path(volume).filename().string()) == pattern;
  };
  return is_numbered && std::all_of(volumes.begin(), volumes.end(), is_alike) &&
         have_one_grid(volumes.front(), volumes.back(), options);
}

// Returns "flow" for "flow_0012.vti"; the folder's name if the file name is only a number.
std::string series_name(const fs::path& volume) {
  std::string name = default_dataset_name(volume);
  const auto ends_here = [](char c) { return is_digit(c) || c == '_' || c == '-' || c == '.'; };
  while (!name.empty() && ends_here(name.back())) name.pop_back();
  if (name.empty()) name = fs::absolute(volume).parent_path().filename().string();
  return name.empty() ? "series" : name;
}

// Returns the only ParaView collection of a folder: it has the times of the files.
std::optional<std::string> collection_in(const std::string& folder) {
  std::optional<std::string> found;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (!is_pvd(at->path())) continue;
    if (found) return std::nullopt;
    found = at->path().string();
  }
  return found;
}

// ---- labels

constexpr std::array<std::string_view, 7> kLabelWords = {
    "seg", "segmentation", "segmentations", "label", "labels", "mask", "masks"};

bool is_label_word(std::string_view word) {
  return std::find(kLabelWords.begin(), kLabelWords.end(), word) != kLabelWords.end();
}

bool is_volume(const fs::path& file) {
  try {
    return recognized_format(file) != nullptr;
  } catch (const VolumeFileError&) {
    return false;
  }
}

// Returns the label images of an OME-Zarr: the groups in its folder "labels".
std::vector<std::string> label_images_in(const fs::path& folder) {
  std::vector<std::string> images;
  std::error_code error;
  for (fs::directory_iterator at(folder / "labels", error), end; !error && at != end;
       at.increment(error)) {
    std::error_code ignored;
    const bool is_group = fs::is_regular_file(at->path() / ".zgroup", ignored) ||
                          fs::is_regular_file(at->path() / "zarr.json", ignored);
    if (is_group) images.push_back(at->path().string());
  }
  std::sort(images.begin(), images.end());
  return images;
}

std::optional<std::string> sidecar_label_map(const fs::path& volume) {
  std::error_code error;
  const fs::path folder = volume.has_parent_path() ? volume.parent_path() : ".";
  const std::string own = lower_case(default_dataset_name(volume));
  std::optional<std::string> named_alike;
  std::optional<std::string> plain;
  std::size_t others = 0;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code ignored;
    if (!at->is_regular_file(ignored) || fs::equivalent(at->path(), volume, ignored)) continue;
    const std::string name = lower_case(default_dataset_name(at->path()));
    const bool has_own = name.size() > own.size() + 1 && name.starts_with(own) &&
                         std::string_view("_-. ").find(name[own.size()]) != std::string::npos;
    const bool is_alike = has_own && is_label_word(std::string_view(name).substr(own.size() + 1));
    if (!is_volume(at->path())) continue;
    if (is_alike) {
      named_alike = at->path().string();
    } else if (is_label_word(name)) {
      plain = at->path().string();
    } else {
      ++others;
    }
  }
  if (named_alike) return named_alike;
  return others == 0 ? plain : std::nullopt;
}

// ---- keys

// Larger files contain their samples; a smaller one may be a header for other files.
constexpr std::uintmax_t kMaxHeaderBytes = 1 << 20;

}  // namespace

fs::path demo_volume() {
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  const fs::path demo = program.parent_path().parent_path() / "share" / "multitetra" / "demo" /
                        "visible_female_head.nrrd";
  if (!unknown && fs::exists(demo, unknown)) return demo;
  throw ExitError(kFailed, "The demo volume is not at '" + demo.string() +
                               "'; give a volume: multitetra view FILE.");
}

bool is_prepared(const std::string& input) {
  if (fs::path(input).extension() == ".mtd") return true;
  if (!is_folder_of_datasets(input) || datasets_in(input).empty()) return false;
  return is_address(input) || volumes_in(input).empty();
}

bool is_unprepared(const std::string& input) {
  if (fs::path(input).extension() == ".mtd") return false;
  if (is_address(input)) return !input.ends_with('/') && !input.starts_with("s3://");
  if (!is_folder_of_datasets(input)) return true;
  return datasets_in(input).empty() && (recognized_format(input) || !volumes_in(input).empty());
}

std::vector<PrepareArguments> preparations_of(std::vector<std::string> inputs,
                                              const VolumeOptions& volume) {
  if (inputs.size() == 1) {
    if (const auto collection = collection_in(inputs.front())) inputs = {*collection};
  }
  std::vector<std::string> volumes;
  for (const PrepareJob& job : jobs_for(inputs, {}, volume.allow_external_files)) {
    volumes.push_back(job.input);
  }
  std::sort(volumes.begin(), volumes.end(),
            [](const std::string& a, const std::string& b) { return natural_order_less(a, b); });
  VolumeFileOptions options = volume.parsed();
  options.choice.first = true;
  PrepareArguments common;
  common.volume = volume;
  const bool chooses_field = !volume.array.empty() || volume.channel.has_value();
  const auto fields_of = [&](const VolumeContents& contents) {
    return contents.fields.size() > 1 && !chooses_field ? std::vector<std::string>{"all"}
                                                        : std::vector<std::string>();
  };
  if (inputs.size() == 1 && is_pvd(inputs.front())) {
    common.inputs = inputs;
    common.series.fields = fields_of(open_volume(volumes.front(), options)->contents());
    return {common};
  }
  if (are_times(volumes, options)) {
    common.inputs = volumes;
    common.series.time_series = series_name(volumes.front());
    common.series.fields = fields_of(open_volume(volumes.front(), options)->contents());
    return {common};
  }
  std::vector<PrepareArguments> preparations;
  for (const std::string& input : volumes) {
    PrepareArguments one = common;
    one.inputs = {input};
    const VolumeContents contents = open_volume(input, options)->contents();
    one.series.fields = fields_of(contents);
    one.series.all_times = contents.times.count > 1 && !volume.time;
    if (!contents.labels.empty() && volume.component.empty()) one.series.labels = {"all"};
    preparations.push_back(std::move(one));
  }
  return preparations;
}

PrepareArguments preparation_of_labels(const std::string& input) {
  PrepareArguments arguments;
  arguments.inputs = {input};
  arguments.series.labels = {"all"};
  return arguments;
}

std::vector<std::string> label_maps_of(const fs::path& volume) {
  std::error_code error;
  if (fs::is_directory(volume, error)) return label_images_in(volume);
  if (!fs::is_regular_file(volume, error)) return {};
  const auto beside = sidecar_label_map(volume);
  return beside ? std::vector{*beside} : std::vector<std::string>();
}

std::string cache_key(const PrepareArguments& arguments) {
  const SeriesArguments& series = arguments.series;
  std::string text = std::string(MULTITETRA_VERSION) + '\0' + arguments.command_line() + '\0' +
                     series.time_series + '\0' + arguments.name + '\0';
  text += std::string(series.all_times ? "times " : "") + (series.fields.empty() ? "" : "fields ") +
          (series.labels.empty() ? "" : "labels ");
  if (!series.label_names.empty()) text += provenance(series.label_names).digest + '\0';
  for (const std::string& input : arguments.inputs) {
    const Provenance note = provenance(input);
    std::error_code no_file;
    const std::uintmax_t bytes =
        fs::is_regular_file(input, no_file) ? fs::file_size(input, no_file) : 0;
    const bool stands_alone = fs::is_directory(input, no_file) || bytes > kMaxHeaderBytes;
    const fs::path place = is_address(input) ? fs::path(input) : fs::absolute(input);
    text += '\0' + note.file + '\0' + note.digest + '\0' + (stands_alone ? "" : place.string());
  }
  std::string name = default_dataset_name(arguments.inputs.front());
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return c < 0x80 && std::isalnum(c) == 0 && c != '-' && c != '_'; },
      '_');
  if (name.size() > 64) name.resize(64);
  return name + "-" + hex_text(checksum(std::as_bytes(std::span(text))));
}

}  // namespace multitetra

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/base/open_file.hpp"
#include "common/base/utf8.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/terminal.hpp"
#include "common/json/json_report.hpp"
#include "common/sandbox/isolation.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/dataset_folder.hpp"
#include "server/programs/label_volume_text.hpp"
#include "server/programs/volume_options.hpp"
#include "server/volume/formats/volume_formats.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

struct InfoArguments {
  std::string file;
  bool json = false;
  bool requires_isolation = false;
};

// Returns the histogram as one line of block characters, logarithmic, in at most `width` columns.
std::string sketch(const Histogram& histogram, std::size_t width) {
  static const char* const kBlocks[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::vector<double> columns(std::min(width, histogram.counts.size()), 0);
  for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    columns[bin * columns.size() / histogram.counts.size()] +=
        static_cast<double>(histogram.counts[bin]);
  }
  const double tallest = columns.empty() ? 0 : *std::max_element(columns.begin(), columns.end());
  std::string line;
  for (const double count : columns) {
    const double share = tallest > 0 ? std::log1p(count) / std::log1p(tallest) : 0;
    line += kBlocks[static_cast<std::size_t>(std::ceil(8 * share))];
  }
  return line;
}

std::string vector_text(const Vec3& v) {
  return human_number(v[0]) + " " + human_number(v[1]) + " " + human_number(v[2]);
}

std::string with_unit(const std::string& numbers, const std::string& unit) {
  return unit.empty() ? numbers : numbers + " " + unit;
}

std::uint64_t sample_bytes(const DatasetInfo& info) {
  auto bytes = static_cast<std::uint64_t>(bytes_per_sample(info.type));
  for (const std::int32_t side : info.dims) bytes *= static_cast<std::uint64_t>(side);
  return bytes;
}

std::size_t bins_of(const PreparedFile& file) {
  const std::size_t edges = file.bins().size() / sizeof(float);
  return edges == 0 ? 0 : edges - 1;
}

std::uint64_t packed_sample_bytes(const PreparedFile& file) {
  return find_section(file.sections(), section_names::kSamples)->size;
}

// Prints the fields of the description that print_facts() does not put into words.
void print_other_fields(const DatasetInfo& info,
                        const std::function<void(const char*, const std::string&)>& line) {
  static const std::set<std::string_view> kInWords = {
      "name",        "dims",          "type",           "spacing",
      "min",         "max",           "space",          "geometry",
      "assumed",     "void_samples",  "outside",        "margin",
      "length_unit", "grid_exponent", "member",         "index_to_world",
      "value_unit",  "histogram",     "display_window", "suggested_isovalues",
      "missing"};
  const Json fields = multitetra::json_of(info);
  for (const auto& [name, value] : fields.items()) {
    if (kInWords.contains(name) || value.is_null()) continue;
    line(name.c_str(), value.is_string() ? value.get<std::string>() : json_text(value));
  }
}

void print_facts(const std::string& place, const PreparedFile& file) {
  const DatasetInfo& info = file.info();
  const Provenance& source = file.metadata().source;
  const auto line = [](const char* what, const std::string& value) {
    std::cout << "  " << what << std::string(20 - std::string(what).size(), ' ')
              << printable(value, /*keeps_lines=*/false) << "\n";
  };
  std::cout << printable("\"" + info.name + "\" in " + without_password(place),
                         /*keeps_lines=*/false)
            << "\n";
  line("samples", sides_text(info.dims) + " " + std::string(name(info.type)));
  if (info.member) line("member of series", human_member(*info.member));
  if (file.metadata().label_volume) {
    line("volume", human_label_volume(*file.metadata().label_volume, info));
  }
  line("spacing", with_unit(vector_text(info.spacing), info.meaning.length_unit));
  if (const std::string basis = geometry_text(info.meaning); !basis.empty()) {
    line("geometry", basis);
  }
  line("world axes", info.meaning.space == WorldSpace::kUnnamed
                         ? "those of the file"
                         : std::string(name(info.meaning.space)));
  line("origin", human_place(info.index_to_world.translation, voxel_length(info)));
  line("x, y, z axes", "(" + vector_text(info.index_to_world.columns[0]) + "), (" +
                           vector_text(info.index_to_world.columns[1]) + "), (" +
                           vector_text(info.index_to_world.columns[2]) + ") per sample");
  line("values", with_unit(human_value(info.min, info) + " to " + human_value(info.max, info),
                           info.meaning.value_unit));
  if (info.display_window) {
    line("display window", with_unit(human_value(info.display_window->low, info) + " to " +
                                         human_value(info.display_window->high, info),
                                     info.meaning.value_unit));
  }
  line("void samples", human_count(info.void_samples) + " (NaN: no surface there)");
  line("outside", info.outside ? shortest_text(*info.outside) + " (value beyond the data)"
                               : "void (surfaces end at the last sample)");
  line("margin", std::to_string(info.margin) + (info.margin == 1 ? " layer" : " layers") +
                     " of samples around the data");
  line("grid", std::to_string(1 << info.grid_exponent) + " steps a side");
  line("histogram (log)", sketch(info.histogram, 64));
  print_other_fields(info, line);
  line("suggested isovalues", human_suggestions(info));
  line("size", human_bytes(file.bytes()) + ", " + human_bytes(packed_sample_bytes(file)) +
                   " of it samples (" + human_bytes(sample_bytes(info)) + " decompressed)");
  line("error spectrum", "errors for " + std::to_string(bins_of(file)) + " bins of isovalues" +
                             (info.missing.empty() ? "" : " are missing; prepare FILE adds them"));
  line("format version", std::to_string(kPreparedFormatVersion));
  line("source", source.file + (source.digest.empty() ? "" : " (XXH3-128 " + source.digest + ")") +
                     (source.options.empty() ? "" : ", " + source.options));
}

Json json_of(const PreparedFile& file) {
  const DatasetInfo& info = file.info();
  const Provenance& source = file.metadata().source;
  Json report = multitetra::json_of(info);
  report["file_bytes"] = file.bytes();
  report["sample_bytes"] = sample_bytes(info);
  report["packed_sample_bytes"] = packed_sample_bytes(file);
  report["spectrum_bins"] = bins_of(file);
  report["format_version"] = kPreparedFormatVersion;
  if (const auto& volume = file.metadata().label_volume) {
    report["label_volume"] = multitetra::json_of(*volume);
  }
  report["source"] = {
      {"file", source.file}, {"digest", source.digest}, {"options", source.options}};
  return report;
}

// What this kernel has for isolating the readers of files.
void print_report(Json report) {
  const Isolation isolation = isolation_of_this_kernel();
  report["isolation"] = {{"landlock", isolation.landlock}, {"seccomp", isolation.seccomp}};
  std::cout << text_of(report);
}

int info_of_folder(const InfoArguments& arguments) {
  Json datasets = Json::array();
  const auto print_failure = [&](const std::string& place) {
    const PreparedFile file(place);
    if (arguments.json) {
      datasets.push_back(json_of(file));
    } else {
      print_facts(place, file);
    }
  };
  const ExitCode code = with_each_dataset(arguments.file, print_failure, [](const auto&...) {});
  if (arguments.json) print_report({{"datasets", std::move(datasets)}});
  return code;
}

// ---- sources: volume files that are not prepared

Json json_of(const VolumeSource& source) {
  const VolumeHeader& header = source.header();
  const VolumeContents& contents = source.contents();
  Json entries = Json::array();
  for (const SourceEntry& entry : contents.entries) {
    entries.push_back({{"kind", entry.kind},
                       {"name", entry.name},
                       {"detail", entry.detail},
                       {"option", entry.option}});
  }
  Json fields = Json::array();
  for (const SourceField& field : contents.fields) fields.push_back(field.name);
  Json labels = Json::array();
  for (const SourceLabel& label : contents.labels) {
    labels.push_back({{"value", label.label.value}, {"name", label.label.name}});
  }
  return {{"dims", header.dims},
          {"type", name(header.type)},
          {"spacing", header.spacing},
          {"origin", header.index_to_world.translation},
          {"space", name(header.meaning.space)},
          {"length_unit", header.meaning.length_unit},
          {"value_unit", header.meaning.value_unit},
          {"geometry", name(header.meaning.geometry)},
          {"assumed", header.meaning.assumed},
          {"values", header.values},
          {"times", contents.times.count},
          {"fields", std::move(fields)},
          {"labels", std::move(labels)},
          {"entries", std::move(entries)}};
}

void print_source(const std::string& place, const VolumeSource& source) {
  const VolumeHeader& header = source.header();
  const VolumeContents& contents = source.contents();
  std::vector<std::vector<std::string>> rows = {
      {"  samples", sides_text(header.dims) + " " + std::string(name(header.type))},
      {"  spacing", with_unit(vector_text(header.spacing), header.meaning.length_unit)},
      {"  origin",
       human_place(header.index_to_world.translation, std::ranges::min(header.spacing))},
      {"  geometry", geometry_text(header.meaning)},
      {"  values", header.values}};
  if (contents.times.count > 1) {
    rows.push_back({"  times", std::to_string(contents.times.count) + " (--time, --all-times)"});
  }
  for (const SourceField& field : contents.fields) {
    rows.push_back({"  field", field.name + " (--field)"});
  }
  for (const SourceLabel& label : contents.labels) {
    rows.push_back({"  label", std::to_string(static_cast<std::int64_t>(label.label.value)) + " " +
                                   label.label.name});
  }
  for (const SourceEntry& entry : contents.entries) {
    rows.push_back({"  " + entry.kind, entry.name + (entry.detail.empty() ? "" : ", ") +
                                           entry.detail + " (" + entry.option + ")"});
  }
  for (auto& row : rows) row[1] = printable(row[1], /*keeps_lines=*/false);
  std::cout << printable(without_password(place), /*keeps_lines=*/false) << "\n"
            << text_table(rows);
}

// Returns whether it exists here and is a volume rather than a dataset or a folder of some.
bool is_source(const std::string& file) {
  std::error_code error;
  const std::filesystem::path path = file.substr(0, file.rfind(":/"));
  if (std::filesystem::is_directory(path, error)) return recognized_format(path) != nullptr;
  return std::filesystem::is_regular_file(path, error) && OpenFile(path).content(4) != "\x89MTD";
}

int info_of_source(const InfoArguments& arguments) {
  apply_isolation_option(arguments.requires_isolation);
  const auto notice = [&](const std::string& text) {
    if (!arguments.json) std::cerr << printable(text, /*keeps_lines=*/false) << "\n";
  };
  try {
    const auto source = open_volume(
        arguments.file, {.choice = {.resample = true, .first = true}, .notice = notice});
    if (arguments.json) {
      print_report(json_of(*source));
    } else {
      print_source(arguments.file, *source);
    }
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
  return kOk;
}

int info(const InfoArguments& arguments) {
  if (is_source(arguments.file)) return info_of_source(arguments);
  if (is_folder_of_datasets(arguments.file)) return info_of_folder(arguments);
  const PreparedFile file(arguments.file);
  if (arguments.json) {
    print_report(json_of(file));
  } else {
    print_facts(arguments.file, file);
  }
  return kOk;
}

}  // namespace

void add_info_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<InfoArguments>();
  Command* command = program.add_subcommand(
      "info",
      "Print the properties of a dataset or of a volume file, with all that can be chosen in it");
  command
      ->add_option(
          "file", arguments->file,
          "Dataset: a file (.mtd) or the address of a dataset (https://, s3://bucket/key); a "
          "local folder or one in a bucket: all of its datasets; or a volume file")
      ->required()
      ->type_name("DATASET");
  command->add_flag("--json", arguments->json, "Print JSON, with the histogram");
  add_isolation_option(*command, arguments->requires_isolation);
  command->footer(
      "Examples:\n"
      "  multitetra-server info head.mtd\n"
      "  multitetra-server info head.mtd --json | jq .suggested_isovalues\n"
      "  multitetra-server info run.h5");
  command->callback([arguments, &run] { run = [arguments] { return info(*arguments); }; });
}

}  // namespace multitetra

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/dataset/objects/object_dataset.hpp"
#include "server/dataset/objects/object_structure.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/dataset_folder.hpp"

namespace multitetra {
namespace {

struct InfoArguments {
  std::string file;
  bool json = false;
};

// The histogram as one line of blocks, logarithmic, `width` columns.
std::string sketch(const Histogram& histogram, std::size_t width) {
  static const char* const kBlocks[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::vector<double> columns(std::min(width, histogram.counts.size()), 0);
  for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    columns[bin * columns.size() / histogram.counts.size()] +=
        static_cast<double>(histogram.counts[bin]);
  }
  const double most = columns.empty() ? 0 : *std::max_element(columns.begin(), columns.end());
  std::string line;
  for (const double count : columns) {
    const double share = most > 0 ? std::log1p(count) / std::log1p(most) : 0;
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

// What is told of a file and of a dataset made of objects alike.
struct KnownFacts {
  DatasetMetadata metadata;
  std::size_t bins = 0;
  std::uint64_t bytes = 0;
  std::string format;
};

std::size_t bins_between(std::size_t edge_bytes) {
  const std::size_t edges = edge_bytes / sizeof(float);
  return edges == 0 ? 0 : edges - 1;
}

KnownFacts facts_of(const std::string& place) {
  if (!is_object_dataset(place)) {
    const PreparedFile file(place);
    return {.metadata = file.metadata(),
            .bins = bins_between(file.bins().size()),
            .bytes = std::filesystem::file_size(place),
            .format = std::to_string(kPreparedFormatVersion)};
  }
  const auto cache = std::make_shared<ObjectCache>();
  const ObjectReader reader(cache->place(place), cache);
  const ObjectStructure structure = reader.structure();
  std::uint64_t bytes = structure.manifest.first.bytes + structure.manifest.later.bytes;
  for (const char* const large : {section_names::kSamples, section_names::kSpectrum}) {
    bytes += find_section(structure.manifest.sections, large)->size;
  }
  return {.metadata = structure.metadata,
          .bins = bins_between(structure.bins.size()),
          .bytes = bytes,
          .format = std::to_string(kPreparedFormatVersion) + " in objects of version " +
                    std::to_string(structure.manifest.shares_objects ? kSharedObjectsVersion
                                                                     : kObjectsVersion)};
}

void print_facts(const std::string& file, const KnownFacts& facts) {
  const DatasetInfo& info = facts.metadata.info;
  const SourceNote& source = facts.metadata.source;
  const auto line = [](const char* what, const std::string& value) {
    std::cout << "  " << what << std::string(20 - std::string(what).size(), ' ') << value << "\n";
  };
  std::cout << "\"" << info.name << "\" in " << file << "\n";
  line("samples", std::to_string(info.dims[0]) + " x " + std::to_string(info.dims[1]) + " x " +
                      std::to_string(info.dims[2]) + " " + std::string(name(info.type)));
  if (info.member) line("member of family", human_member(*info.member));
  line("spacing", with_unit(vector_text(info.spacing), info.meaning.length_unit));
  line("world axes", info.meaning.space == WorldSpace::kUnnamed
                         ? "the file's own"
                         : std::string(name(info.meaning.space)));
  line("origin", vector_text(info.index_to_world.translation));
  line("x, y, z axes", "(" + vector_text(info.index_to_world.columns[0]) + "), (" +
                           vector_text(info.index_to_world.columns[1]) + "), (" +
                           vector_text(info.index_to_world.columns[2]) + ") per sample");
  line("values", with_unit(human_number(info.min) + " to " + human_number(info.max),
                           info.meaning.value_unit));
  line("void samples", human_count(info.void_samples) + " (NaN: no surface there)");
  line("outside", info.outside ? human_number(*info.outside) + " is the value beyond the data"
                               : "void (surfaces end at the last sample)");
  line("margin", std::to_string(info.margin) + " grid steps around the data");
  line("grid", std::to_string(1 << info.grid_exponent) + " steps a side");
  line("histogram (log)", sketch(info.histogram, 64));
  std::string isovalues;
  for (const double isovalue : info.suggested_isovalues) isovalues += human_number(isovalue) + "  ";
  line("suggested isovalues", isovalues.empty() ? "none" : isovalues);
  line("size",
       human_bytes(facts.bytes) + ", " + human_bytes(sample_bytes(info)) + " of it samples");
  line("error spectrum", "errors for " + std::to_string(facts.bins) + " bins of isovalues");
  line("format version", facts.format);
  line("source", source.file + (source.digest.empty() ? "" : " (XXH3-128 " + source.digest + ")") +
                     (source.options.empty() ? "" : ", " + source.options));
}

Json json_of(const KnownFacts& facts) {
  const DatasetInfo& info = facts.metadata.info;
  const SourceNote& source = facts.metadata.source;
  Json report = multitetra::json_of(info);
  report["file_bytes"] = facts.bytes;
  report["sample_bytes"] = sample_bytes(info);
  report["spectrum_bins"] = facts.bins;
  report["format_version"] = kPreparedFormatVersion;
  report["source"] = {
      {"file", source.file}, {"digest", source.digest}, {"options", source.options}};
  return report;
}

int info_of_folder(const InfoArguments& arguments) {
  Json datasets = Json::array();
  const auto tell = [&](const std::string& place) {
    const KnownFacts facts = facts_of(place);
    if (arguments.json) {
      datasets.push_back(json_of(facts));
    } else {
      print_facts(place, facts);
    }
  };
  const ExitCode code = with_each_dataset(arguments.file, tell, [](const auto&...) {});
  if (arguments.json) std::cout << text_of({{"datasets", std::move(datasets)}});
  return code;
}

int info(const InfoArguments& arguments) {
  if (is_folder_of_datasets(arguments.file)) return info_of_folder(arguments);
  const KnownFacts facts = facts_of(arguments.file);
  if (arguments.json) {
    std::cout << text_of(json_of(facts));
  } else {
    print_facts(arguments.file, facts);
  }
  return kOk;
}

}  // namespace

void add_info_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<InfoArguments>();
  Command* command = program.add_subcommand("info", "Tell what a dataset holds");
  command
      ->add_option("file", arguments->file,
                   "Dataset: a file (.mtd), a folder of objects, or an address of one; of a folder "
                   "of datasets all are told")
      ->required()
      ->type_name("DATASET");
  command->add_flag("--json", arguments->json, "Print JSON, with the histogram");
  command->footer(
      "Examples:\n"
      "  multitetra-server info head.mtd\n"
      "  multitetra-server info head.mtd --json | jq .suggested_isovalues");
  command->callback([arguments, &run] { run = [arguments] { return info(*arguments); }; });
}

}  // namespace multitetra

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "common/human_units.hpp"
#include "common/json_report.hpp"
#include "server/dataset/dataset_file.hpp"
#include "server/dataset/dataset_format.hpp"
#include "server/service/commands.hpp"

namespace multitetra {
namespace {

struct Arguments {
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

void print_facts(const std::string& file, const Dataset& dataset, const SourceNote& source) {
  const DatasetInfo& info = dataset.info;
  const auto line = [](const char* what, const std::string& value) {
    std::cout << "  " << what << std::string(20 - std::string(what).size(), ' ') << value << "\n";
  };
  std::cout << "\"" << info.name << "\" in " << file << "\n";
  line("samples", std::to_string(info.dims[0]) + " x " + std::to_string(info.dims[1]) + " x " +
                      std::to_string(info.dims[2]) + " " + std::string(name(info.type)));
  line("spacing", vector_text(info.spacing));
  line("origin", vector_text(info.index_to_world.translation));
  line("x, y, z axes", "(" + vector_text(info.index_to_world.columns[0]) + "), (" +
                           vector_text(info.index_to_world.columns[1]) + "), (" +
                           vector_text(info.index_to_world.columns[2]) + ") per sample");
  line("values", human_number(info.min) + " to " + human_number(info.max));
  line("void samples", human_count(info.void_samples));
  line("outside", info.outside ? human_number(*info.outside) : "void");
  line("margin", std::to_string(info.margin));
  line("grid", std::to_string(1 << info.grid_exponent) + " steps a side");
  line("histogram (log)", sketch(info.histogram, 64));
  std::string isovalues;
  for (const double isovalue : info.suggested_isovalues) isovalues += human_number(isovalue) + "  ";
  line("suggested isovalues", isovalues.empty() ? "none" : isovalues);
  line("size", human_bytes(std::filesystem::file_size(file)) + ", " +
                   human_bytes(dataset.volume.size() *
                               static_cast<std::size_t>(bytes_per_sample(info.type))) +
                   " of it samples");
  line("format version", std::to_string(kDatasetFormatVersion));
  line("source", source.file + (source.digest.empty() ? "" : " (XXH3-128 " + source.digest + ")"));
}

int info(const Arguments& arguments) {
  const DatasetPtr dataset = open_dataset(arguments.file);
  const SourceNote source = read_source_note(arguments.file);
  if (!arguments.json) {
    print_facts(arguments.file, *dataset, source);
    return 0;
  }
  Json report = json_of(dataset->info);
  report["file_bytes"] = std::filesystem::file_size(arguments.file);
  report["sample_bytes"] =
      dataset->volume.size() * static_cast<std::size_t>(bytes_per_sample(dataset->info.type));
  report["format_version"] = kDatasetFormatVersion;
  report["source"] = {{"file", source.file}, {"digest", source.digest}};
  std::cout << text_of(report);
  return 0;
}

}  // namespace

void add_info_command(CLI::App& program, Run& run) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("info", "Tell what a dataset file holds");
  command->add_option("file", arguments->file, "Dataset file (.mtd)")->required();
  command->add_flag("--json", arguments->json, "Print JSON, with the histogram");
  command->footer(
      "Examples:\n"
      "  multitetra-server info head.mtd\n"
      "  multitetra-server info head.mtd --json | jq .suggested_isovalues");
  command->callback([arguments, &run] { run = [arguments] { return info(*arguments); }; });
}

}  // namespace multitetra

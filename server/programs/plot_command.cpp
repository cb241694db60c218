#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/json.hpp"
#include "common/cli/output_files.hpp"
#include "common/json/json_report.hpp"
#include "common/wire/mesh_files.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/plot/dataset_plot.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/thread_options.hpp"

namespace multitetra {
namespace {

struct PlotArguments {
  std::string file;
  std::string output;
  std::vector<double> errors = {0.25, 0.5, 1, 2, 4};
  std::size_t isovalues = 64;
  std::string simplify = "on";
  int threads = 0;
  bool json = false;
  bool quiet = false;
};

Json report_of(const PlotArguments& arguments, const DatasetInfo& info, const SizeCurves& curves,
               const Progress& progress) {
  Json sizes = Json::array();
  for (std::size_t i = 0; i < curves.errors.size(); ++i) {
    sizes.push_back({{"error", curves.errors[i]}, {"triangles", curves.triangles[i]}});
  }
  return {{"dataset", info.name},
          {"plot_file", arguments.output},
          {"unit", "voxel"},
          {"simplify", arguments.simplify == "on"},
          {"isovalues", curves.isovalues},
          {"sizes", std::move(sizes)},
          {"suggested_isovalues", info.suggested_isovalues},
          {"seconds", progress.seconds()}};
}

int plot(const PlotArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  const std::string suffix = std::filesystem::path(arguments.output).extension();
  if (std::ranges::count(kDrawingSuffixes, suffix) == 0) {
    throw std::invalid_argument("\"" + arguments.output +
                                "\" is no file name of a plot; plots are *.svg, *.pdf or *.png.");
  }
  require_outputs({{"--output", arguments.output}}, {{"file", arguments.file}});
  Progress progress("plot", 2, arguments.quiet || arguments.json);
  progress.begin("open");
  const DatasetPtr dataset = open_dataset(arguments.file);
  const SurfaceExtractor extractor(dataset);
  progress.begin("sizes");
  const SizeCurves curves = size_curves(
      extractor, even_isovalues(dataset->info, arguments.isovalues), arguments.errors,
      {.simplify = arguments.simplify == "on", .progress = [&](std::size_t done, std::size_t all) {
         progress.update(static_cast<double>(done), static_cast<double>(all), "isovalues");
       }});
  write_file(arguments.output, drawing(suffix, kPlotWidth, kPlotHeight, [&](Canvas& canvas) {
               draw_dataset_plot(canvas, dataset->info, curves);
             }));
  progress.finish();
  if (arguments.json) {
    std::cout << text_of(report_of(arguments, dataset->info, curves, progress));
  } else if (!arguments.quiet) {
    std::cout << arguments.output << ": the values of \"" << dataset->info.name << "\" and the "
              << "sizes of their surfaces\n";
  }
  return 0;
}

}  // namespace

void add_plot_command(Command& program, Run& run) {
  const auto a = std::make_shared<PlotArguments>();
  Command* command = program.add_subcommand(
      "plot", "Draw a dataset's histogram and the sizes of its surfaces (SVG)");
  command
      ->add_option("file", a->file,
                   "Dataset: a file (.mtd) or the address of a dataset (https://, s3://bucket/key)")
      ->required()
      ->type_name("DATASET");
  command->add_option("-o,--output", a->output, "Drawing to write (.svg, .pdf, .png)")
      ->required()
      ->type_name("FILE");
  command->add_option("--errors", a->errors, "Errors in voxels, a curve for each")
      ->within(0.0, 1e6)
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--isovalues", a->isovalues, "Number of isovalues")
      ->within(2, 1000)
      ->capture_default_str();
  command
      ->add_option("--simplify", a->simplify,
                   "Count simplified surfaces; off: all triangles of marching tetrahedra")
      ->one_of({"on", "off"})
      ->capture_default_str();
  add_threads_option(*command, a->threads);
  command->add_flag("--json", a->json, "Print the numbers of the curves as JSON");
  command->add_flag("--quiet", a->quiet, "Print errors only");
  command->footer(
      "Numbers of triangles are estimates from a sample of the surface: without simplification "
      "within\n"
      "a few percent, otherwise mostly within a third.\n"
      "Examples:\n"
      "  multitetra-server plot head.mtd -o head.svg\n"
      "  multitetra-server plot head.mtd --errors 0.5,2 --isovalues 200 -o head.svg --json");
  command->callback([a, &run] { run = [a] { return plot(*a); }; });
}

}  // namespace multitetra

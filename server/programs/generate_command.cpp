#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/progress.hpp"
#include "server/volume/generators/generators.hpp"
#include "server/volume/generators/written_nrrd.hpp"

namespace multitetra {
namespace {

struct GenerateArguments {
  std::string kind;
  GeneratorOptions options;
  std::string output;
  bool json = false;
  bool quiet = false;
};

int generate_volume(const GenerateArguments& arguments) {
  const GeneratorKind kind = generator_kind_from(arguments.kind).value();
  const auto volume = generated_volume(kind, arguments.options);
  const VolumeHeader& header = volume->header();
  Progress progress("generate", 1, arguments.quiet || arguments.json);
  progress.begin("samples");
  write_nrrd(arguments.output, *volume,
             [&](std::int32_t slices) { progress.update(slices, header.dims[2], "slices"); });
  progress.finish();
  if (arguments.json) {
    std::cout << text_of({{"kind", arguments.kind},
                          {"file", arguments.output},
                          {"dims", header.dims},
                          {"type", name(header.type)},
                          {"suggested_isovalue", suggested_isovalue(kind)},
                          {"seconds", progress.seconds()}});
  } else if (!arguments.quiet) {
    std::cerr << "generate: " << arguments.output << " holds " << arguments.kind << ", "
              << sides_text(header.dims) << " " << name(header.type) << "; isovalue "
              << human_number(suggested_isovalue(kind)) << std::endl;
  }
  return 0;
}

}  // namespace

void add_generate_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<GenerateArguments>();
  Command* command = program.add_subcommand("generate", "Generate a volume from a formula");
  std::vector<std::string> kinds;
  for (const GeneratorKind kind : kGeneratorKinds) kinds.emplace_back(name(kind));
  command->add_option("kind", arguments->kind, "Formula of the volume")->required()->one_of(kinds);
  command->add_option("--size", arguments->options.size, "Samples a side, 2 to 4097")
      ->capture_default_str();
  command->add_option("--noise", arguments->options.noise, "Standard deviation of the noise")
      ->capture_default_str();
  command->add_option("--seed", arguments->options.seed, "Seed of the noise")
      ->capture_default_str();
  command->add_option("-o,--output", arguments->output, "NRRD file to write")
      ->required()
      ->type_name("FILE");
  command->add_flag("--json", arguments->json, "Print a JSON report");
  command->add_flag("--quiet", arguments->quiet, "Print errors only");
  command->footer(
      "Examples:\n"
      "  multitetra-server generate gyroid --size 65 -o gyroid.nrrd\n"
      "  multitetra-server generate head --size 256 --noise 30 --seed 7 -o head.nrrd");
  command->callback(
      [arguments, &run] { run = [arguments] { return generate_volume(*arguments); }; });
}

}  // namespace multitetra

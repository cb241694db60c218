#include <iostream>
#include <memory>
#include <string>

#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "server/programs/commands.hpp"
#include "server/volume/formats/volume_formats.hpp"

namespace multitetra {
namespace {

int list_formats(bool as_json) {
  if (as_json) {
    Json report = Json::array();
    for (const VolumeFormat& format : volume_formats()) {
      report.push_back({{"name", format.name}, {"files", format.files}, {"notes", format.notes}});
    }
    std::cout << text_of(report);
    return 0;
  }
  for (const VolumeFormat& format : volume_formats()) {
    std::cout << format.name << ": " << format.files << "\n    " << format.notes << "\n";
  }
  return 0;
}

}  // namespace

void add_formats_command(Command& program, Run& run) {
  const auto as_json = std::make_shared<bool>(false);
  Command* command = program.add_subcommand("formats", "List the supported volume formats");
  command->add_flag("--json", *as_json, "Print JSON");
  command->footer(
      "Examples:\n"
      "  multitetra-server formats\n"
      "  multitetra-server formats --json | jq '.[].name'");
  command->callback([as_json, &run] { run = [as_json] { return list_formats(*as_json); }; });
}

}  // namespace multitetra

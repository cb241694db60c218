#include "client/commands/color_options.hpp"

#include "common/base/parse_number.hpp"
#include "common/cli/human_units.hpp"

namespace multitetra {
namespace {

std::optional<ScalarRequest::Limits> limits_from(const std::string& text) {
  const auto ends = parse_numbers<double>(text, 2);
  if (!ends) return std::nullopt;
  return ScalarRequest::Limits{ends->front(), ends->back()};
}

}  // namespace

void add_color_options(Command& command, ColorArguments& arguments) {
  const std::string group = "Colours";
  command
      .add_option(
          "--color-by", arguments.dataset,
          "Colour the surface by the values of this dataset, which may be another one in the "
          "same world: values and colours are in .ply, .glb and .vtp files")
      ->type_name("DATASET")
      ->group(group);
  command.add_option("--colors", arguments.map, "Colours from the least to the greatest value")
      ->one_of({"viridis", "cividis", "coolwarm", "gray"})
      ->capture_default_str()
      ->group(group);
  command
      .add_option(
          "--color-range", arguments.range,
          "Which values the colours span; what is beyond has the colour of the end (default: "
          "the dataset's range)")
      ->type_name("LOW,HIGH")
      ->group(group);
  command
      .add_flag("--color-log", arguments.is_logarithmic,
                "Colours by the logarithm; the range must be above 0")
      ->group(group);
  command
      .add_option("--no-value-color", arguments.no_value,
                  "The colour where the dataset has no value")
      ->type_name("RRGGBB")
      ->capture_default_str()
      ->group(group);
}

Result<std::optional<ScalarRequest>> scalars_of(const ColorArguments& arguments) {
  const auto wrong = [](const std::string& text) {
    return fail(ErrorCode::kInvalidArgument, text);
  };
  if (arguments.dataset.empty()) {
    if (arguments.range.empty() && !arguments.is_logarithmic) return std::nullopt;
    return wrong("--color-range and --color-log need --color-by DATASET, whose values they are.");
  }
  ScalarRequest request{.dataset = arguments.dataset};
  if (!arguments.range.empty()) {
    request.limits = limits_from(arguments.range);
    if (!request.limits) {
      return wrong("--color-range: \"" + arguments.range +
                   "\" is no range; one looks like -10,250.5.");
    }
  }
  if (!rgb_from(arguments.no_value)) {
    return wrong("--no-value-color: \"" + arguments.no_value +
                 "\" is no colour; one looks like ff8000.");
  }
  if (arguments.is_logarithmic && !(request.limits && request.limits->low > 0)) {
    return wrong("--color-log needs --color-range LOW,HIGH with both above 0.");
  }
  const auto valid = validated(request);
  if (!valid) return wrong("--color-range: " + valid.error().text);
  return request;
}

void paint(PositionedMesh& mesh, const StepBegin& step, const ColorArguments& arguments) {
  if (!step.scalars || mesh.scalars.empty()) return;
  const ColorScale scale{.map = color_map_from(arguments.map).value_or(ColorMap::kViridis),
                         .low = step.scalars->low,
                         .high = step.scalars->high,
                         .is_logarithmic = arguments.is_logarithmic,
                         .no_value = rgb_from(arguments.no_value).value_or(Rgb{})};
  mesh.colors = colors_of(mesh.scalars, scale);
}

std::string accuracy_text(const CommittedStep& step) {
  if (!step.begin.scalars) return {};
  return "Colours between vertices may be off by up to " +
         human_number(step.largest_scalar_deviation) + ", those of vertices by " +
         human_number(0.5 * step.begin.scalars->step()) + ".";
}

}  // namespace multitetra

// Surfaces that are coloured by a field: the options of commands that write or draw one.
#pragma once

#include <optional>
#include <string>

#include "client/library/assembler.hpp"
#include "common/cli/command.hpp"
#include "common/image/color_map.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/scalar_request.hpp"

namespace multitetra {

struct ColorArguments {
  std::string dataset = {};  // Whose values colour the surface; empty: none.
  std::string map = "viridis";
  std::string range = {};  // LOW,HIGH; empty: all values of that dataset.
  bool is_logarithmic = false;
  std::string no_value = "808080";  // RRGGBB.
};

void add_color_options(Command& command, ColorArguments& arguments);

// What is to be asked for; nullopt where no dataset is named. kInvalidArgument, naming the option.
[[nodiscard]] Result<std::optional<ScalarRequest>> scalars_of(const ColorArguments& arguments);

// Gives the mesh the colours of its scalars, if it has some.
void paint(PositionedMesh& mesh, const StepBegin& step, const ColorArguments& arguments);

// "Colours between vertices may be off by up to 0.12, those of vertices by 0.01."; empty without
// scalars.
[[nodiscard]] std::string accuracy_text(const CommittedStep& step);

}  // namespace multitetra

#include "server/programs/prepare_arguments.hpp"

#include <cmath>
#include <exception>
#include <stdexcept>

namespace multitetra {

std::optional<double> PrepareArguments::outside_value() const {
  if (outside == "void") return std::nullopt;
  try {
    std::size_t used = 0;
    const double value = std::stod(outside, &used);
    if (used == outside.size() && std::isfinite(value)) return value;
  } catch (const std::exception&) {  // Told below.
  }
  throw std::invalid_argument("--outside is \"" + outside +
                              "\"; it must be void or a finite number.");
}

std::string PrepareArguments::told() const {
  std::string text = volume.told();
  const auto tell = [&](const char* option, const std::string& value, const std::string& usual) {
    if (value != usual) text += std::string(text.empty() ? "" : " ") + option + " " + value;
  };
  tell("--outside", outside, "void");
  tell("--margin", std::to_string(margin), "0");
  tell("--bins", std::to_string(bins), std::to_string(IsovalueBins::kDefaultCount));
  return text;
}

}  // namespace multitetra

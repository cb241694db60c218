#include "server/volume/formats/volume_contents.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/text.hpp"
#include "common/base/utf8.hpp"
#include "common/dataset/physical_meaning.hpp"

namespace multitetra {
SourceTimes even_times(std::int64_t count, double first, double step, std::string_view unit) {
  SourceTimes times{.count = count};
  const double last = first + step * static_cast<double>(count - 1);
  const bool is_known = count >= 2 && count <= std::int64_t{kMaxSourceMembers};
  if (!is_known || !std::isfinite(first) || !std::isfinite(last) || !(step > 0)) return times;
  for (std::int64_t i = 0; i < count; ++i) {
    times.at.push_back(first + step * static_cast<double>(i));
  }
  times.unit = time_unit_from(unit);
  return times;
}

std::string time_unit_from(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 12> kSymbols = {
      {{"sec", "s"},
       {"second", "s"},
       {"seconds", "s"},
       {"msec", "ms"},
       {"millisecond", "ms"},
       {"milliseconds", "ms"},
       {"us", "µs"},
       {"usec", "µs"},
       {"microsecond", "µs"},
       {"microseconds", "µs"},
       {"minute", "min"},
       {"hour", "h"}}};
  const std::string word = lower_case(text);
  for (const auto& [name, symbol] : kSymbols) {
    if (word == name) return std::string(symbol);
  }
  return is_unit_text(text) ? std::string(text) : std::string();
}

std::string member_name_from(std::string_view text) {
  text = trimmed(text);
  return text.size() <= kMaxMemberTextBytes && is_plain_text(text) ? std::string(text)
                                                                   : std::string();
}

bool have_layers(const std::vector<SourceLabel>& labels) {
  return std::any_of(labels.begin(), labels.end(),
                     [](const SourceLabel& label) { return label.layer != 0; });
}

}  // namespace multitetra

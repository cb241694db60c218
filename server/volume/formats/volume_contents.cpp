#include "server/volume/formats/volume_contents.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/json.hpp"
#include "common/base/text.hpp"
#include "common/base/utf8.hpp"
#include "common/dataset/physical_meaning.hpp"

namespace multitetra {
namespace {

using ContentsJson = nlohmann::json;

}  // namespace

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

std::string contents_text(const VolumeContents& contents) {
  ContentsJson fields = ContentsJson::array();
  for (const SourceField& field : contents.fields) {
    fields.push_back({field.name, field.array,
                      field.channel ? ContentsJson(*field.channel) : ContentsJson(),
                      field.components, field.color ? ContentsJson(*field.color) : ContentsJson()});
  }
  ContentsJson labels = ContentsJson::array();
  for (const auto& [label, stored, layer] : contents.labels) {
    labels.push_back({label.value, label.name,
                      label.color ? ContentsJson(*label.color) : ContentsJson(), stored, layer});
  }
  ContentsJson entries = ContentsJson::array();
  for (const auto& [kind, name, detail, option] : contents.entries) {
    entries.push_back({kind, name, detail, option});
  }
  return json_text(ContentsJson{
      {"entries", std::move(entries)},
      {"times", contents.times.count},
      {"at", contents.times.at},
      {"unit", contents.times.unit},
      {"fields", std::move(fields)},
      {"labels", std::move(labels)},
      {"unnamed", contents.unnamed},
      {"recommended", contents.recommended_isovalue ? ContentsJson(*contents.recommended_isovalue)
                                                    : ContentsJson()},
      {"window", contents.display_window
                     ? ContentsJson({contents.display_window->low, contents.display_window->high})
                     : ContentsJson()}});
}

VolumeContents contents_from(std::string_view text) {
  const ContentsJson json = parse_json(text);
  VolumeContents contents;
  contents.times = {.count = json.at("times").get<std::int64_t>(),
                    .at = json.at("at").get<std::vector<double>>(),
                    .unit = json.at("unit").get<std::string>()};
  contents.unnamed = json.at("unnamed").get<std::vector<std::string>>();
  if (const ContentsJson& isovalue = json.at("recommended"); !isovalue.is_null()) {
    contents.recommended_isovalue = isovalue.get<double>();
  }
  if (const ContentsJson& window = json.at("window"); !window.is_null()) {
    contents.display_window = {.low = window.at(0).get<double>(),
                               .high = window.at(1).get<double>()};
  }
  for (const ContentsJson& entry : json.at("entries")) {
    contents.entries.push_back({entry.at(0).get<std::string>(), entry.at(1).get<std::string>(),
                                entry.at(2).get<std::string>(), entry.at(3).get<std::string>()});
  }
  for (const ContentsJson& field : json.at("fields")) {
    contents.fields.push_back(
        {.name = field.at(0).get<std::string>(), .array = field.at(1).get<std::string>()});
    if (!field.at(2).is_null()) contents.fields.back().channel = field.at(2).get<std::int64_t>();
    contents.fields.back().components = field.at(3).get<std::int64_t>();
    if (!field.at(4).is_null()) contents.fields.back().color = field.at(4).get<std::uint32_t>();
  }
  for (const ContentsJson& label : json.at("labels")) {
    contents.labels.push_back(
        {.label = {.value = label.at(0).get<double>(), .name = label.at(1).get<std::string>()},
         .stored = label.at(3).get<double>(),
         .layer = label.at(4).get<int>()});
    if (label.at(2).is_null()) continue;
    contents.labels.back().label.color = label.at(2).get<std::uint32_t>();
  }
  return contents;
}

}  // namespace multitetra

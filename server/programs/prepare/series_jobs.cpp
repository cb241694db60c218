#include "server/programs/prepare/series_jobs.hpp"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/base/natural_order.hpp"
#include "common/base/utf8.hpp"
#include "server/programs/prepare/label_jobs.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

using Notice = std::function<void(const std::string&)>;

// One time of a series: a volume, or a frame of one.
struct Moment {
  std::string input;
  std::optional<std::int64_t> index = std::nullopt;  // The frame in the input.
  std::optional<double> time = std::nullopt;
};

struct SeriesSource {
  std::string name;
  std::vector<Moment> moments;
  std::string time_unit = {};
  VolumeContents contents = {};
};

// Returns the contents of a volume.
VolumeContents contents_of(const std::string& input, const PrepareArguments& arguments) {
  VolumeFileOptions options = arguments.volume.parsed();
  options.choice.first = true;
  return open_volume(input, options)->contents();
}

bool increase(const std::vector<double>& times) {
  return std::adjacent_find(times.begin(), times.end(),
                            [](double a, double b) { return !(a < b); }) == times.end();
}

std::vector<double> frame_numbers(std::size_t count) {
  std::vector<double> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<double>(i);
  return numbers;
}

// ---- times

SeriesSource series_of_volume(const std::string& input, const std::string& name,
                              const PrepareArguments& arguments, const Notice& notice) {
  SeriesSource series{
      .name = name, .moments = {{.input = input}}, .contents = contents_of(input, arguments)};
  const SeriesArguments& requested = arguments.series;
  const SourceTimes& source_times = series.contents.times;
  if (!requested.all_times) return series;
  if (source_times.count > std::int64_t{kMaxSeriesJobs}) {
    throw ExitError(kUsage, "'" + input + "' has " + std::to_string(source_times.count) +
                                " times; --all-times prepares a dataset of each, for at most " +
                                std::to_string(kMaxSeriesJobs) + ".");
  }
  const auto count = static_cast<std::size_t>(source_times.count);
  std::vector<double> times = requested.time_values(count);
  if (times.empty() && !source_times.at.empty() && increase(source_times.at)) {
    times = source_times.at;
    series.time_unit = source_times.unit;
  }
  if (count == 1) {
    notice("'" + input + "' has only one time.");
  } else if (times.empty()) {
    notice("'" + input + "' has no time stamps; using frames 0, 1, 2, ...");
  }
  if (times.empty()) times = frame_numbers(count);
  if (!requested.time_unit.empty()) series.time_unit = requested.time_unit;
  series.moments.clear();
  for (std::size_t i = 0; i < count; ++i) {
    series.moments.push_back(
        {.input = input, .index = static_cast<std::int64_t>(i), .time = times[i]});
  }
  return series;
}

// Returns the times that the files state, the first one of which has these contents; none unless
// all state one and they increase.
std::vector<double> stated_times(const std::vector<std::string>& inputs,
                                 const VolumeContents& first, const PrepareArguments& arguments) {
  std::vector<double> times = first.times.at;
  for (std::size_t i = 1; i < inputs.size() && times.size() == i; ++i) {
    const std::vector<double> at = contents_of(inputs[i], arguments).times.at;
    times.insert(times.end(), at.begin(), at.end());
  }
  return times.size() == inputs.size() && increase(times) ? times : std::vector<double>();
}

SeriesSource series_of_files(const PrepareArguments& arguments) {
  std::vector<std::string> inputs;
  std::vector<double> collected;
  for (const PrepareJob& job :
       jobs_for(arguments.inputs, arguments.output, arguments.volume.allow_external_files)) {
    inputs.push_back(job.input);
    if (job.collected_time) collected.push_back(*job.collected_time);
  }
  const bool are_collected = collected.size() == inputs.size() && increase(collected);
  if (!are_collected) {
    std::sort(inputs.begin(), inputs.end(),
              [](const std::string& a, const std::string& b) { return natural_order_less(a, b); });
  }
  const SeriesArguments& requested = arguments.series;
  SeriesSource series{.name = requested.time_series,
                      .moments = {},
                      .time_unit = requested.time_unit,
                      .contents = contents_of(inputs.front(), arguments)};
  std::vector<double> times = requested.time_values(inputs.size());
  if (times.empty() && are_collected) times = collected;
  if (times.empty()) times = stated_times(inputs, series.contents, arguments);
  if (times.empty()) times = frame_numbers(inputs.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    series.moments.push_back({.input = inputs[i], .time = times[i]});
  }
  return series;
}

// ---- fields

// A field, and the choice of its samples.
struct FieldChoice {
  std::string name;  // Empty: the only one.
  SourceField source = {};
  std::optional<std::string> component = std::nullopt;
};

std::string list_of_names(const std::vector<SourceField>& fields) {
  std::string names;
  for (const SourceField& field : fields) {
    if (names.size() > 600) return names + ", ...";
    names += (names.empty() ? "" : ", ") + field.name;
  }
  return names;
}

std::vector<SourceField> requested_fields(const SeriesSource& series,
                                          const PrepareArguments& arguments, const Notice& notice) {
  const std::vector<SourceField>& all = series.contents.fields;
  const SeriesArguments& requested = arguments.series;
  const std::string& input = series.moments.front().input;
  if (requested.fields.empty()) return {SourceField{}};
  std::vector<SourceField> fields;
  if (requested.wants_all_fields()) {
    for (const std::string& name : series.contents.unnamed) {
      notice("'" + series.moments.front().input + "': field '" + printable(name, false) +
             "' is skipped because its name is empty, too long or has control characters. Prepare "
             "it separately with --array.");
    }
    const bool chooses = !arguments.volume.component.empty() || !requested.components.empty();
    for (const SourceField& field : all) {
      if (field.components == 1 || chooses) {
        fields.push_back(field);
      } else {
        notice("'" + input + "': field " + field.name + " has " + std::to_string(field.components) +
               " components and is skipped; select one with --component.");
      }
    }
    if (fields.empty()) fields.emplace_back();
    return fields;
  }
  for (const std::string& name : requested.fields) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const SourceField& field) {
      return field.name == name || (!field.array.empty() && field.array == name);
    });
    if (found == all.end()) {
      throw ExitError(kUsage, "'" + input + "' has no field " + name + ". " +
                                  (all.empty() ? "It has only one field"
                                               : "Its fields are " + list_of_names(all)) +
                                  ".");
    }
    fields.push_back(*found);
  }
  return fields;
}

std::vector<FieldChoice> field_choices(const SeriesSource& series,
                                       const PrepareArguments& arguments, const Notice& notice) {
  std::vector<FieldChoice> choices;
  for (const SourceField& field : requested_fields(series, arguments, notice)) {
    if (arguments.series.components.empty())
      choices.push_back({.name = field.name, .source = field});
    for (const std::string& component : arguments.series.components) {
      const bool is_number = component.find_first_not_of("0123456789") == std::string::npos;
      const std::string component_name = is_number ? "component" + component : component;
      choices.push_back(
          {.name = field.name.empty() ? component_name : field.name + " " + component_name,
           .source = field,
           .component = component});
    }
  }
  return choices;
}

// Makes a part of a file name: keeps letters, digits and harmless characters.
std::string name_part(const std::string& text) {
  std::string part;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool stays = (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') ||
                       (byte >= '0' && byte <= '9') || byte >= 0x80 || c == '-' || c == '.' ||
                       c == '_' || c == '+';
    part += stays ? c : '_';
  }
  return part;
}

// Returns a unique part of a name for each field.
std::vector<std::string> field_parts(const std::vector<FieldChoice>& fields) {
  std::set<std::string> taken;
  std::vector<std::string> parts;
  for (const FieldChoice& field : fields) {
    const std::string base = name_part(field.name);
    std::string part = base;
    for (int i = 2; !taken.insert(part).second; ++i) part = base + "_" + std::to_string(i);
    parts.push_back(part);
  }
  return parts;
}

// ---- all jobs

std::string time_part(std::size_t frame) {
  char text[24];
  std::snprintf(text, sizeof text, ".t%04zu", frame);
  return text;
}

void add_jobs(const SeriesSource& series, const PrepareArguments& arguments, LatestLabelMap& maps,
              const Notice& notice, std::vector<PrepareJob>& jobs) {
  const std::vector<FieldChoice> fields = field_choices(series, arguments, notice);
  const std::vector<std::string> parts = field_parts(fields);
  const LabelJobs labels(arguments, maps, series.moments.front().input, series.contents.labels);
  if (!labels.notice().empty()) notice(labels.notice());
  for (std::size_t frame = 0; frame < series.moments.size(); ++frame) {
    const Moment& moment = series.moments[frame];
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const FieldChoice& field = fields[f];
      PrepareJob volume{.input = moment.input,
                        .output = {},
                        .name = series.name,
                        .choice = arguments.volume.parsed().choice,
                        .member = SeriesMember{.series = series.name,
                                               .field = field.name,
                                               .time = moment.time,
                                               .time_unit = series.time_unit,
                                               .color = field.source.color}};
      if (!field.name.empty()) volume.name += "." + parts[f];
      if (moment.time) volume.name += time_part(frame);
      if (moment.index) {
        volume.choice.time = moment.index;
        volume.command_line.push_back("--time " + std::to_string(*moment.index));
      }
      if (!field.source.array.empty()) {
        volume.choice.array = field.source.array;
        volume.command_line.push_back("--array " + field.source.array);
      }
      if (field.source.channel) {
        volume.choice.channel = field.source.channel;
        volume.command_line.push_back("--channel " + std::to_string(*field.source.channel));
      }
      if (field.component) {
        volume.choice.component = component_from(*field.component);
        volume.command_line.push_back("--component " + *field.component);
      }
      for (PrepareJob& job : labels.of(volume)) {
        job.output = std::filesystem::path(arguments.output) / (job.name + ".mtd");
        jobs.push_back(std::move(job));
      }
      if (jobs.size() > kMaxSeriesJobs) {
        throw ExitError(kUsage, "There are more than " + std::to_string(kMaxSeriesJobs) +
                                    " members. Prepare fewer times, fields or labels at once.");
      }
    }
  }
}

}  // namespace

std::vector<PrepareJob> jobs_of(const PrepareArguments& arguments, LatestLabelMap& maps,
                                const Notice& notice) {
  std::vector<PrepareJob> jobs;
  if (!arguments.series.time_series.empty()) {
    add_jobs(series_of_files(arguments), arguments, maps, notice, jobs);
    return jobs;
  }
  if (arguments.inputs.size() == 1 && is_pvd(arguments.inputs.front())) {
    PrepareArguments collection = arguments;
    collection.name.clear();
    collection.series.time_series =
        arguments.name.empty() ? default_dataset_name(arguments.inputs.front()) : arguments.name;
    return jobs_of(collection, maps, notice);
  }
  std::vector<PrepareJob> volumes =
      jobs_for(arguments.inputs, arguments.output, arguments.volume.allow_external_files);
  if (!arguments.name.empty() && volumes.size() > 1) {
    throw ExitError(kUsage, "--name is for one volume; several are named after their files.");
  }
  for (PrepareJob& volume : volumes) {
    if (!arguments.name.empty()) {
      volume.name = arguments.name;
      volume.output = volume.output.parent_path() / (volume.name + ".mtd");
    }
    if (arguments.series.are_given()) {
      add_jobs(series_of_volume(volume.input, volume.name, arguments, notice), arguments, maps,
               notice, jobs);
    } else {
      volume.choice = arguments.volume.parsed().choice;
      jobs.push_back(std::move(volume));
    }
  }
  return jobs;
}

}  // namespace multitetra

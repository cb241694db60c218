// Volumes that scripts write with other programs are read with their expected meaning, or refused
// with an error message.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "server/volume/formats/volume_formats.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/sweep.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

using Fields = std::vector<std::string>;

std::vector<Fields> written_volumes(const std::string& script, const fs::path& folder,
                                    const std::string& more = "") {
  const fs::path list = folder / "list.txt";
  const std::string command = std::string(MULTITETRA_PYTHON) + " " + MULTITETRA_VOLUME_SCRIPTS +
                              "/" + script + " " + folder.string() + " " + more + " > " +
                              list.string();
  const std::string python = MULTITETRA_PYTHON;
  if (std::system((python + " -c 'import numpy' 2> /dev/null").c_str()) != 0) return {};
  EXPECT_EQ(std::system(command.c_str()), 0) << script;
  std::vector<Fields> volumes;
  std::ifstream in(list);
  for (std::string line; std::getline(in, line);) {
    Fields& fields = volumes.emplace_back();
    std::istringstream words(line + "\t");
    for (std::string field; std::getline(words, field, '\t');) fields.push_back(field);
    if (fields[0] != "missing") continue;
    std::cerr << "NOT TESTED: volumes that need the Python package " << fields[1] << "\n";
    volumes.pop_back();
  }
  return volumes;
}

// Parses "0.5:1.5:2".
Vec3 vector_from(std::string text) {
  Vec3 numbers{};
  std::replace(text.begin(), text.end(), ':', ' ');
  std::istringstream(text) >> numbers[0] >> numbers[1] >> numbers[2];
  return numbers;
}

Placement placement_from(const std::string& options) {
  Placement placement;
  std::istringstream words(options);
  for (std::string word; std::getline(words, word, ',');) {
    if (word.starts_with("spacing=")) placement.spacing = vector_from(word.substr(8));
    if (word.starts_with("origin=")) placement.origin = vector_from(word.substr(7));
    if (word.starts_with("unit=")) placement.length_unit = unit_from(word.substr(5));
  }
  return placement;
}

// Parses a choice such as "resample,follow,time=1,array=name".
VolumeChoice choice_from(const std::string& options) {
  VolumeChoice choice;
  std::istringstream words(options);
  for (std::string word; std::getline(words, word, ',');) {
    const std::string value = word.substr(std::min(word.find('=') + 1, word.size()));
    if (word == "resample") choice.resample = true;
    if (word == "follow") choice.allow_external_files = true;
    if (word == "loss") choice.allow_loss = true;
    if (word == "first") choice.first = true;
    if (word.starts_with("subtract=")) choice.subtract = std::stod(value);
    if (word.starts_with("time=")) choice.time = std::stoi(value);
    if (word.starts_with("channel=")) choice.channel = std::stoi(value);
    if (word.starts_with("level=")) choice.level = std::stoi(value);
    if (word.starts_with("array=")) choice.array = value;
    if (word.starts_with("series=")) choice.series = value;
    if (word.starts_with("component=")) choice.component = ComponentChoice::from(value).value();
  }
  return choice;
}

// "1:liver:FF0000:0;2:spleen:-:0": value, name, color and layer.
std::string text_of(const std::vector<SourceLabel>& labels) {
  std::ostringstream text;
  for (const auto& [label, stored, layer] : labels) {
    text << (text.tellp() > 0 ? ";" : "") << label.value << ":" << label.name << ":";
    if (label.color) text << std::hex << std::uppercase << *label.color << std::dec;
    text << ":" << layer;
  }
  return text.str();
}

std::vector<float> floats_of(const fs::path& file) {
  const std::string bytes = bytes_of_file(file);
  std::vector<float> numbers(bytes.size() / sizeof(float));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

// A file that leads to others does so from any current folder.
void expect_opened_by_name(const Fields& fields) {
  const fs::path path = fields[2];
  const std::set<std::string> leading = {".xml", ".nhdr", ".mhd", ".pvti", ".dat"};
  if (!leading.contains(path.extension().string())) return;
  const fs::path before = fs::current_path();
  fs::current_path(path.parent_path());
  EXPECT_NO_THROW((void)open_volume(
      path.filename(), {.choice = choice_from(fields[3]), .placement = placement_from(fields[3])}));
  fs::current_path(before);
}

// "dims=8:1:1": that many bytes at the end of the file.
std::optional<RawLayout> layout_from(const std::string& path, const std::string& options) {
  const std::size_t at = options.find("dims=");
  if (at == std::string::npos) return std::nullopt;
  const Vec3 dims = vector_from(options.substr(at + 5, options.find(',', at) - at - 5));
  RawLayout layout{.header_bytes = fs::file_size(path)};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    layout.dims[axis] = static_cast<std::int32_t>(dims[axis]);
  }
  layout.header_bytes -= static_cast<std::uint64_t>(dims[0] * dims[1] * dims[2]);
  return layout;
}

// Returns the reason why a volume is not read; empty if it is.
std::string refusal(const std::string& path, const std::string& options) {
  try {
    (void)read_volume(path, {.raw = layout_from(path, options),
                             .choice = choice_from(options),
                             .placement = placement_from(options)});
    return {};
  } catch (const VolumeFileError& problem) {
    return problem.what();
  }
}

// Returns the first name of a list: "it has 2 arrays: /a, /b. Select one".
std::string first_listed(const std::string& text) {
  const std::size_t begin = text.find(": ", text.find("it has "));
  if (begin == std::string::npos) return {};
  return text.substr(begin + 2, text.find_first_of(",. ", begin + 2) - begin - 2);
}

// Returns the options with those that the reason of a refusal names, or without one that it says to
// omit.
std::string with_remedies(const std::string& reason, std::string options) {
  const std::vector<std::pair<std::string, std::string>> remedies = {
      {"--time", "time=0"},
      {"--channel", "channel=0"},
      {"--component", "component=0"},
      {"--series", "series=1"},
      {"--level", "level=0"},
      {"--resample", "resample"},
      {"--follow", "follow"},
      {"--spacing", "spacing=1:1:1"},
      {"--origin", "origin=0:0:0"},
      {"--length-unit", "unit=mm"},
      {"--dims", "dims=2:2:2"},
      {"--allow-loss", "loss"},
      {"--subtract",
       "subtract=" + reason.substr(std::min(reason.find("--subtract") + 11, reason.size()))},
      {"--array", "array=" + first_listed(reason)},
      {":/path", "array=" + first_listed(reason)}};
  for (const auto& [option, value] : remedies) {
    const std::size_t at = reason.find(option);
    if (at == std::string::npos) continue;
    const std::string key = value.substr(0, value.find('='));
    std::string kept;
    std::istringstream words(options);
    for (std::string word; std::getline(words, word, ',');) {
      if (word.substr(0, word.find('=')) != key) kept += word + ",";
    }
    options = reason.find("Omit " + option) == std::string::npos ? kept + value + "," : kept;
  }
  return options;
}

// Where a text offers to prepare each time or field, the source lists several, and each is read, or
// refused for another reason.
void expect_members_read(const std::string& path, const std::string& text,
                         const std::string& options) {
  const bool has_times = text.find("--all-times") != std::string::npos;
  const bool has_fields = text.find("--field") != std::string::npos;
  const bool has_series = text.find("Choose one with --series") != std::string::npos;
  if (!has_times && !has_fields && !has_series) return;
  const VolumeContents contents =
      open_volume(path, {.choice = choice_from(options + ",first")})->contents();
  EXPECT_TRUE(!has_series || contents.entries.size() > 1) << text;
  if (has_times) {
    EXPECT_GT(contents.times.count, 1) << text;
    for (const std::int64_t time : {std::int64_t{0}, contents.times.count - 1}) {
      const std::string reason = refusal(path, options + ",time=" + std::to_string(time));
      EXPECT_EQ(reason.find("--time"), std::string::npos) << text << "\n  " << time << reason;
    }
  }
  EXPECT_TRUE(!has_fields || contents.fields.size() + contents.unnamed.size() > 1) << text;
  for (std::size_t i = 0; has_fields && i < std::min<std::size_t>(contents.fields.size(), 4); ++i) {
    const SourceField& field = contents.fields[i];
    std::string choice = field.components > 1 ? ",component=0" : "";
    if (!field.array.empty()) choice += ",array=" + field.array;
    if (field.channel) choice += ",channel=" + std::to_string(*field.channel);
    const std::string reason = refusal(path, options + choice);
    EXPECT_EQ(reason.find("--field"), std::string::npos) << text << "\n  " << choice << reason;
  }
}

// Each remedy that a refusal names works: following them leads to a volume, or to another reason
// without a remedy by options.
void expect_remedies_work(const std::string& path, std::string reason, std::string options) {
  std::string tried = reason;
  for (int step = 0; step < 4 && with_remedies(reason, {}) != ""; ++step) {
    expect_members_read(path, reason, options);
    options = with_remedies(reason, options);
    reason = refusal(path, options);
    tried += "\n  with " + options + " " + reason;
  }
  EXPECT_EQ(with_remedies(reason, {}), "") << tried;
}

void expect_read(const Fields& fields) {
  expect_opened_by_name(fields);
  const auto number = [&](std::size_t at) { return std::stod(fields.at(5 + at)); };
  std::string notices;
  Volume volume;
  try {
    volume = read_volume(fields[2],
                         {.choice = choice_from(fields[3]),
                          .placement = placement_from(fields[3]),
                          .notice = [&](const std::string& text) { notices += text + "\n"; }});
  } catch (const VolumeFileError& problem) {
    ADD_FAILURE() << problem.what();
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(volume.dims[axis], static_cast<std::int32_t>(number(axis))) << axis;
    EXPECT_NEAR(volume.index_to_world.translation[axis], number(3 + axis), 1e-5) << axis;
    for (std::size_t row = 0; row < 3; ++row) {
      EXPECT_NEAR(volume.index_to_world.columns[axis][row], number(6 + 3 * axis + row), 1e-6)
          << axis << row;
    }
  }
  EXPECT_EQ(volume.meaning.length_unit, fields.at(20));
  const std::string& notice = fields.at(21);  // Must not be there if it begins with '!'.
  if (notice.starts_with('!')) {
    EXPECT_EQ(notices.find(notice.substr(1)), std::string::npos) << notices;
  } else {
    EXPECT_NE(notices.find(notice), std::string::npos) << notices;
  }
  expect_members_read(fields[2], notices, fields[3]);
  const bool has_series = !choice_from(fields[3]).series.empty();
  if (const std::string& labels = fields.at(22); has_series || !labels.empty()) {
    const VolumeContents contents =
        open_volume(fields[2], {.choice = choice_from(fields[3])})->contents();
    EXPECT_EQ(text_of(contents.labels), labels);
    EXPECT_TRUE(!has_series || contents.entries.size() > 1) << "no series are listed";
  }
  const std::vector<float> expected = floats_of(fields[4]);
  std::visit(
      [&](const auto& samples) {
        ASSERT_EQ(samples.size(), expected.size());
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
          const auto sample = static_cast<float>(samples[i]);
          const bool is_right =
              std::isnan(expected[i]) ? std::isnan(sample) : std::abs(sample - expected[i]) < 1e-3F;
          if (is_right) continue;
          if (++wrong < 4) ADD_FAILURE() << i << ": " << sample << ", not " << expected[i];
        }
        EXPECT_EQ(wrong, 0u);
      },
      volume.samples);
}

void expect_refused(const Fields& fields) {
  const std::string reason = refusal(fields[2], fields[3]);
  EXPECT_NE(reason.find(fields.at(4)), std::string::npos) << reason;
  EXPECT_NE(reason, "") << "it is read";
  expect_remedies_work(fields[2], reason, fields[3]);
  if (fields.at(5).empty()) return;
  const std::string option = "--" + fields[5].substr(0, fields[5].find('='));
  EXPECT_NE(reason.find(option), std::string::npos) << reason;
  EXPECT_EQ(refusal(fields[2], fields[5]), "");
}

void expect_as_written(const std::string& script) {
  const TemporaryFolder folder;
  const std::vector<Fields> volumes = written_volumes(script, folder.path());
  if (volumes.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  for (const Fields& fields : volumes) {
    SCOPED_TRACE(fields.at(1));
    if (fields[0] == "read") {
      expect_read(fields);
    } else {
      expect_refused(fields);
    }
  }
}

TEST(VolumeFileVariants, ReadAsWritten) { expect_as_written("write_odd_volumes.py"); }

TEST(VolumeConventions, ReadAsWritten) { expect_as_written("write_conventions.py"); }

// A new format needs a line in write_unstated.py: a file that states no spacing, or why there is
// none, and how scaling, sign and missing values of such a file are known.
TEST(EveryFormat, SaysWhatItDoesNotKnow) {
  const TemporaryFolder folder;
  const std::vector<Fields> lines = written_volumes("write_unstated.py", folder.path());
  if (lines.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  std::set<std::string> written;
  for (const Fields& line : lines) written.insert(line.at(1));
  for (const VolumeFormat& format : volume_formats()) {
    EXPECT_TRUE(written.contains(std::string(format.name))) << format.name;
  }
  for (const Fields& line : lines) {
    if (line[0] == "reason") continue;
    SCOPED_TRACE(line.at(2));
    const ValueBasis values = recognized_format(line[2])->open(line[2], {}).header.values;
    EXPECT_EQ(name(values.scaling), line.at(3)) << "scaling";
    EXPECT_EQ(name(values.sign), line.at(4)) << "sign";
    EXPECT_EQ(name(values.missing), line.at(5)) << "missing values";
    if (line[0] == "values") continue;
    const VolumeFormat* const format = recognized_format(line[2]);
    EXPECT_EQ(format == nullptr ? "unknown" : format->name, line[1]);
    std::string notices;
    const auto source =
        open_volume(line[2], {.notice = [&](const std::string& text) { notices += text + "\n"; }});
    EXPECT_NE(source->header().meaning.geometry, GeometryBasis::kStated);
    EXPECT_TRUE(has_assumed_spacing(source->header().meaning)) << source->header().meaning.assumed;
    EXPECT_NE(notices.find("the file states no spacing along x, y and z; 1"), std::string::npos)
        << notices;
    const auto settled = open_volume(line[2], {.placement = {.spacing = Vec3{1, 2, 3}}});
    EXPECT_FALSE(has_assumed_spacing(settled->header().meaning));
  }
}

TEST(VolumeFileVariants, ReadTheConventionsOfDicom) {
  expect_as_written("write_dicom_conventions.py");
}

TEST(VolumeFileVariants, ReadTheConventionsOfFiles) {
  expect_as_written("write_file_conventions.py");
}

// Reads each kind of file in variants of size, type, order, packing and placement. Another seed:
// MULTITETRA_SEED=2 formats_test --gtest_filter=RandomVolumeFiles.*
void expect_variants_read(const std::string& script) {
  const TemporaryFolder folder;
  const char* const seed = std::getenv("MULTITETRA_SEED");
  const std::vector<Fields> volumes = written_volumes(
      script, folder.path(), testing::sweep<std::string>("16 ", "60 ") + (seed ? seed : "1"));
  if (volumes.empty()) GTEST_SKIP() << "NOT TESTED: there is no Python with numpy";
  for (const Fields& fields : volumes) {
    SCOPED_TRACE(fields.at(1));
    expect_read(fields);
  }
}

TEST(RandomVolumeFiles, ReadAsWritten) { expect_variants_read("write_random_volumes.py"); }

TEST(RandomVolumeFiles, ReadAsWrittenInFurtherFormats) {
  expect_variants_read("write_random_files.py");
}

}  // namespace
}  // namespace multitetra
